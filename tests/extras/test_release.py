"""Archive and wheel of a release, and README's commands in a new environment of that wheel."""

import json
import os
import shlex
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path
from typing import Any

import pytest
from tests.pages._engine import ROOT, Result, evaluated, marks, rendered, results, sources, stamped
from tests.test_docs import blocks, commands

pytest.importorskip("build", reason="needs the extra [release]")
pytest.importorskip("twine", reason="needs the extra [release]")

VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
README = (ROOT / "README.md").read_text(encoding="utf-8")
KNOWN = sources()
RUN = [KNOWN[n] for n in dict.fromkeys(mark.partition(".")[0] for mark in marks(README))]
RUN = [source for source in RUN if not source.claim]
"""Sources of README's numbers that are commands."""


@pytest.fixture(scope="module")
def dist(tmp_path_factory) -> Path:
    """Folder of the archive, and of the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, "-m", "build", "--outdir", folder, ROOT], check=True)
    return folder


def test_archive_and_wheel_pass_twine(dist):
    files = sorted(dist.iterdir())
    stem = f"armside-{VERSION}"
    assert [file.name for file in files] == [f"{stem}-py3-none-any.whl", f"{stem}.tar.gz"]
    subprocess.run([sys.executable, "-m", "twine", "check", "--strict", *files], check=True)


def lines() -> list[tuple[str, ...]]:
    """README's lines in their order, then those that its text has numbers of."""
    typed = [command for block in blocks(README) for command in commands(block)]
    sourced = [f"armside {line}" for source in RUN for line in source.lines]
    split = (tuple(shlex.split(line, comments=True)[1:]) for line in (*typed, *sourced))
    return list(dict.fromkeys(split))


@pytest.fixture(scope="module")
def printed(dist, tmp_path_factory) -> tuple[Path, dict[tuple[str, ...], str]]:
    """An empty folder but for the archive's examples, and what each line prints there."""
    env, folder = (tmp_path_factory.mktemp(name) for name in ("env", "reader"))
    (wheel,) = dist.glob("*.whl")
    (archive,) = dist.glob("*.tar.gz")
    subprocess.run([sys.executable, "-m", "venv", env], check=True)
    pip = [env / "bin" / "python", "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "install", f"{wheel}[parts]"], check=True)
    with tarfile.open(archive) as files:
        inside = f"{wheel.name.partition('-py3')[0]}/docs/examples/"
        files.extractall(folder, [m for m in files if m.name.startswith(inside)], filter="data")
    (folder / inside.partition("/")[0] / "docs").rename(folder / "docs")
    variables = {name: v for name, v in os.environ.items() if not name.startswith("PYTHON")}
    found = {}
    for line in lines():
        done = subprocess.run(
            [env / "bin" / "armside", *line],
            cwd=folder, env=variables, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, f"{line}: {done.stderr}"
        found[line] = done.stdout
    return folder, found


def read(line: tuple[str, ...], text: str) -> dict[str, Any]:
    """The tables that a line prints, as the fields of its JSON that they show."""
    _, _, text = text.rpartition("All contours:")
    cells = (row[1:-1].split("│") for row in text.splitlines() if row.startswith("│"))
    rows = [[cell.strip() for cell in row] for row in cells]
    if line[0] == "calibrate-arm":
        means = {name: {"mean": 1e-3 * float(mean)} for name, mean, *_ in rows[:3]}
        return {"held_out": means}
    if line[0] == "cut":
        first = (row for row in rows if len(row) == 10)  # the others go on to the right
        return {"iterations": [{"arm_rms": 1e-6 * float(row[7])} for row in first]}
    return {
        "iterations": [
            {
                "k": float(k),
                "motor_inf": [1e-3 * float(motor)],
                "arm_rms": 1e-6 * float(rms),
                "arm_maxdev": 1e-6 * float(largest),
                "arm_rms_normalised": 1e-2 * float(of_first),
            }
            for k, motor, rms, largest, of_first in rows
        ]
    }


def stored(line: tuple[str, ...], text: str, folder: Path) -> dict[str, Any]:
    """The summary in the folder that a line names last."""
    return json.loads((folder / text.split()[-1] / "summary.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("form", ["tables", "summary"])
def test_readmes_commands_give_its_numbers(printed, form):
    """In a new environment of the wheel, one after the other in one folder."""
    folder, found = printed
    today = results()
    for source in RUN:
        line = tuple(source.lines[-1].split())
        text = found[line]
        fields = read(line, text) if form == "tables" else stored(line, text, folder)
        values = evaluated(fields, source.values)
        today[source.name] = Result(VERSION, "", source.lines, values)
    assert rendered(README, KNOWN, today, lambda _: False) == stamped(README, "")


def test_a_wrong_number_in_a_table_is_noticed():
    printed = "│ 0 │ 305.3 │ 260.9 │ 464.7 │ 100 │\n│ 5 │ 15.85 │ 109.2 │ 230 │ 41.86 │"
    (source,) = (source for source in RUN if source.name == "default")
    row = [5.0, 15.85, 109.2, 230.0]
    values = evaluated(read(("laser",), printed), {"rows": source.values["iterations"]})
    assert values["rows"][-1] == pytest.approx(row)

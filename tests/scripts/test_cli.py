"""Shared by all commands: options, output and exit status."""

import json
import math
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from cyclopts import Token

from armside.scripts import cli, commands
from armside.scripts.shell.errors import InputError
from armside.scripts.shell.help import first_clause
from armside.scripts.shell.options import read_value


def test_help_lists_every_experiment_with_its_line(armside):
    status, out, err = armside("--help")
    assert (status, err) == (0, "")
    assert out.count("\n") < 60
    assert max(map(len, out.splitlines())) <= 80
    for name, (group, line) in cli.COMMANDS.items():
        assert f"\n{group}:\n" in out
        assert name in out
        assert line in out


def test_version_names_the_distribution(armside):
    assert armside("--version") == (0, f"armside {version('armside')}\n", "")


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_help_of_a_command_is_short_has_the_common_options_and_is_for_users(armside, name):
    status, out, _ = armside(f"{name} --help")
    assert status == 0
    for option in ("--seed", "--out", "--json", "--quiet", "--debug"):
        assert option in out
    assert out.count("\n") < 60
    assert max(map(len, out.splitlines())) <= 80
    assert f"armside {name} --help-all" in out.splitlines()[-1]
    shown = out.split("Parameters:")[0]
    assert not re.search(r"^(Raises|Returns|Yields|Args|Parameters|Attributes)\b", shown, re.M)
    for text in (out, armside(f"{name} --help-all").out):
        words = " ".join(text.replace("│", " ").split())
        assert not re.search(r"\b(Raises|Returns)\b|\w+Error\b", words)
        for default in re.findall(r"default: ([^\]]*)\]", words):
            assert not re.search(r"^[(\[{'\"<]|None|True|False|\w\.[A-Z_]+$", default), default


def test_help_shows_units_and_defaults(armside):
    _, out, _ = armside("probe --help")
    assert "--radius X" in out
    assert "Radius [mm] [default: 5]" in " ".join(out.split())


def test_whole_help_has_what_brief_help_leaves_out(armside):
    brief, whole = armside("laser --help").out, armside("laser --help-all")
    assert (whole.status, whole.err) == (0, "")
    for text in ("correct the first run by it", "same seed, same bits"):
        assert text not in brief
        assert text in " ".join(whole.out.replace("│", " ").split())
    options = set(re.findall(r"--[a-z][\w-]+", brief.split("Parameters:")[1])) - {"--help-all"}
    assert options <= set(re.findall(r"--[a-z][\w-]+", whole.out))


@pytest.mark.parametrize(
    ("text", "brief"),
    [
        ("Cutoff of Q [Hz; default: 10]. Of all motors.", "Cutoff of Q [Hz; default: 10]"),
        (
            "A film (.gif; .mp4 with ffmpeg), 2.5 s; none else.",
            "A film (.gif; .mp4 with ffmpeg), 2.5 s",
        ),
        ("Folder of `armside gears`", "Folder of armside gears"),
        ("", ""),
    ],
)
def test_a_clause_ends_outside_of_brackets_and_numbers(text, brief):
    assert first_clause(text) == brief


def test_a_section_for_programmers_ends_with_its_paragraph(armside):
    """The probe's docstring has one, with text behind it."""
    out = armside("probe --help").out
    assert "RunFailed" not in out
    assert "Writes summary.json." in out


def test_a_command_is_a_function_of_its_own_module():
    files = Path(commands.__file__).parent.glob("[a-z]*.py")
    assert {file.stem.replace("_", "-") for file in files} == set(cli.COMMANDS)
    for name in cli.COMMANDS:
        command = cli.load(name)
        assert command.__module__ == f"armside.scripts.commands.{name.replace('-', '_')}"
    with pytest.raises(InputError, match="Did you mean laser"):
        cli.load("lasr")


def test_help_imports_no_experiment():
    """So it starts at once: `make bench NAME=start` has the seconds."""
    code = (
        "import sys; from armside.scripts import cli; cli.main(['--help'])\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    heavy = {"numpy", "mujoco", "scipy", "sympy", "matplotlib", "rerun", "numba", "pyarrow"}
    imported = set(done.stderr.split())
    assert not heavy & imported
    assert not {name for name in imported if name.startswith("armside.scripts.commands")}


BAD_INPUT = {
    "prob": "Unknown experiment 'prob'. Did you mean probe?",
    "--frobnicate": "Unknown experiment '--frobnicate'",
    "probe --radus 3": "Did you mean --radius?",
    "probe extra": "Unexpected 'extra'",
    "probe --radius": "--radius requires an argument",
    "probe --radius big": '"big"',
    "probe --radius nan": "finite",
    "probe --radius inf": "finite",
    "probe --radius -inf": "finite",
    "probe --radius 1e999": "finite",
    "probe --radius 0": "radius must be > 0 mm, got 0.0",
    "probe --radius 1 --radius 2": "multiple times",
    "probe --iterations 2.5": "whole number",
    "probe --iterations nan": "nan",
    "probe --end odd": 'Choose from: "done", "diverged"',
    "probe --end no-file": "no-such-model.xml",
    "probe --seed -1": "seed must be 0 to 9.22337e+18, got -1",
    "probe --seed 0.5": "whole number",
    "probe --no-json": "Unknown option",
    "probe --out full": "full is not empty",
    "probe --out full/file": "is a file",
    "probe --out full/file/deeper": "is not a folder",
    "probe --out .": "not empty",
    f"probe --out {'a/' * 2200}b": "bytes is too long, at most 4071",
    "export --robot=": "--robot= has an empty value",
    f"convert {'x' * 300}": "File name too long",
    "measure": "requires an argument",
}


@pytest.mark.parametrize("line", BAD_INPUT)
def test_bad_input_is_one_line_and_status_2_and_nothing_is_written(bad_input, tmp_path, line):
    full = tmp_path / "full"
    full.mkdir()
    (full / "file").write_text("kept")
    bad_input(line, BAD_INPUT[line])
    assert (full / "file").read_text() == "kept"


def test_minus_zero_is_zero():
    """A range from +0.0 to -0.0 is empty for a generator of random numbers."""
    assert str(read_value(float, [Token(value="-0.0")])) == "0.0"


def test_a_current_folder_is_not_replaced_even_if_empty(armside):
    status, _, err = armside("probe --out .")
    assert status == 2
    assert "in use" in err


def test_what_fails_while_running_is_one_line_and_status_1(armside, tmp_path):
    for end, said in (
        ("bug", "KeyError: elbow"),
        ("value-error", "ValueError: matrix is singular"),
    ):
        message = f"armside: failed with {said} (--debug shows where)\n"
        assert armside(f"probe --end {end}") == (1, "", message)
    assert not list(tmp_path.rglob("*.json"))


def test_debug_shows_where_it_failed(armside):
    status, _, err = armside("probe --end bug --debug")
    assert status == 1
    assert 'raise KeyError("elbow")' in err


def test_a_diverged_run_keeps_its_folder_and_ends_with_status_1(armside, tmp_path):
    status, _, err = armside("probe --end diverged --out kept")
    assert (status, err) == (1, "armside: diverged at k = 3\n")
    assert (tmp_path / "kept" / "summary.json").exists()


@pytest.mark.parametrize("line", ["probe", "probe --json"])
def test_a_full_disk_behind_stdout_is_status_1(armside_process, line):
    with open("/dev/full", "w") as full:
        status, _, err = armside_process(line, stdout=full)
    assert status == 1
    assert "No space left" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("line", ["probe", "probe --json"])
def test_a_reader_that_leaves_is_no_traceback(armside_process, line):
    with subprocess.Popen(["true"], stdin=subprocess.PIPE) as gone:
        gone.wait()
        status, _, err = armside_process(line, stdout=gone.stdin)
    assert (status, err) == (1, "")


def test_json_is_all_of_stdout_and_strict(armside):
    status, out, err = armside("probe --json --seed 7 --iterations 3.0")

    def refuse(constant):
        raise AssertionError(f"{constant} is not JSON")

    summary = json.loads(out, parse_constant=refuse)
    assert (status, err) == (0, "")
    assert summary["config"]["seed"] == 7
    assert summary["config"]["end"] == "done"
    assert summary["config"]["iterations"] == 3
    assert set(summary["config"]["versions"]) == {"armside", "mujoco", "numpy", "python"}
    assert math.isclose(summary["value"], 0.1, rel_tol=0)
    assert summary["missing"] is None


def test_json_on_stdout_is_the_summary_file(armside, tmp_path):
    _, out, _ = armside("probe --json --out here")
    assert (tmp_path / "here" / "summary.json").read_text() == out


def test_quiet_prints_nothing(armside):
    assert armside("probe --quiet") == (0, "", "")


def test_a_piped_run_prints_its_table_and_no_progress(armside):
    status, out, err = armside("probe")
    assert (status, err) == (0, "")
    assert "0.0625" in out

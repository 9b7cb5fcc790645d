"""Public results and the tests of their unit, sign and size: `results_tested.toml`, read.

A section names what its results are of: commands, by commas, or a kind of file or message. A field
is a path with dots into a summary.json, without indices; `*` stands for names that are data.
"""

import ast
import re
import tomllib
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any

TESTS = Path(__file__).parent
TABLE: dict[str, Any] = tomllib.loads((TESTS / "results_tested.toml").read_text(encoding="utf-8"))
PACKAGES = ("ilc", "kinematics", "scripts", "sim")


def listed(of: str) -> dict[str, dict[str, Any]]:
    """Entries of the sections that are of a command, or of a file or message ("file ...")."""
    every = [] if of.startswith("file ") else ["every summary"]
    return {
        field: entry
        for section, entries in TABLE.items()
        if section in every or of in section.split(", ")
        for field, entry in entries.items()
    }


def matches(path: str, field: str) -> bool:
    """A field of the table is that of a path, or of what it would hold if it were not empty."""
    return fnmatchcase(path, field) or field.startswith(f"{path}.")


def fields(value: Any, path: str = "") -> set[str]:
    """Paths of all values but those of the options."""
    inner: list[tuple[str, Any]] = []
    if isinstance(value, dict):
        inner = [(f"{path}.{name}" if path else str(name), item) for name, item in value.items()]
    elif isinstance(value, list) and any(isinstance(item, dict) for item in value):
        inner = [(path, item) for item in value]
    if not inner or path == "config":
        return {path}
    return set[str]().union(*(fields(item, below) for below, item in inner))


def unlisted(of: str, found: set[str]) -> list[str]:
    """Fields that the table lacks."""
    known = listed(of)
    return sorted(f"{of}: {path}" for path in found if not any(matches(path, one) for one in known))


def command_of(summary: dict[str, Any]) -> str:
    """Name of the sections of a summary."""
    config = summary["config"]
    of, action = config.get("experiment"), config.get("action")
    return f"{of} {action}" if of in ("program", "robot", "scan") else str(of)


@cache
def names_of_tests() -> dict[str, int]:
    """Names of all tests, and in how many files each is."""
    names = dict[str, int]()
    for file in TESTS.rglob("test_*.py"):
        text = file.read_text(encoding="utf-8")
        for name in set(re.findall(r"^ *def (test_\w+)", text, re.MULTILINE)):
            names[name] = names.get(name, 0) + 1
    return names


@cache
def words_of_the_code() -> frozenset[str]:
    """Names, arguments and words of texts in the packages."""
    found = set[str]()
    for package in PACKAGES:
        for file in (TESTS.parent / package).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                for name in ("arg", "attr", "id"):
                    found.add(str(getattr(node, name, "")))
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    found.update(re.findall(r"\w+", node.value))
    return frozenset(found)


SMALL = {
    "laser": "laser --iterations 1 --repetitions 2",
    "cut": "cut plate.dxf --iterations 0 --speed 60 --as-program rapid",
    "again": "laser --from laser --speed 35 --iterations 0",
    "fresh": "laser --speed 35 --iterations 0",
    "measure": "measure laser",
    "correction": "export laser",
    "path": "export laser --what joint-path --to parquet --file path.parquet",
    "tool": "export laser --what tool-path --to parquet --file tool.parquet",
    "into": "export cut --into cut/armside.mod --file into.mod",
    "equations": "export --what pose",
    "read": "program read cut/armside.mod",
    "learn": "learn --plant lag.json --laws heuristic:gamma=0.5,delta=1,cutoff=10 own.py:half"
    " --samples 50 --iterations 1",
    "more": "learn --from learn --iterations 0",
    "design": "design --model lag.json --cutoff 10",
    "plant": "identify-plant --plant lag.json --structures oe --largest-order 2 --largest-delay 3"
    " --from-rest",
    "calibrated": f"calibrate-arm {TESTS.parent}/docs/examples/ur10_tmac --robot ur10"
    " --harmonics 0 --in-order --next 3",
    "imu": "imu",
    "rest": "imu --motion rest --off 4 --on 4",
    "check": "robot check",
    "show": "robot show",
    "model": "robot model",
    "build": "robot build",
    "new": "robot new",
}
"""By folder the command lines whose results are all compared with the table."""


def make_small(folder: Path) -> None:
    """Run them in a folder."""
    import contextlib

    import ezdxf

    from armside.scripts import cli

    folder.mkdir(parents=True)
    document = ezdxf.new(units=4)  # pyright: ignore[reportPrivateImportUsage]
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (16, 0), (16, 12), (0, 12)], close=True)
    space.add_circle((6, 6), 4.0)
    document.saveas(folder / "plate.dxf")
    (folder / "lag.json").write_text('{"sample_time": 0.01, "b": [0, 0.1], "a": [1, -0.9]}')
    (folder / "own.py").write_text("def half(u, e):\n    return u + 0.5 * e\n")
    with contextlib.chdir(folder):
        for name, line in SMALL.items():
            assert cli.main([*line.split(), "--quiet", "--out", name]) == 0, line

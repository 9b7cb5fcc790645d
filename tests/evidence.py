"""What judges the product from outside: claims, benchmarks and pictures, each a file of its folder.

The name of a file is the name: `tests/gallery/first_cut.py` is the picture `first-cut`. A file of
claims may hold variants: `CLAIM_REST` of `tests/claims/imu.py` is the claim `imu-rest`. Files that
begin with an underscore are shared, and those that begin with `test_` are tests.
"""

import difflib
import re
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from rich.console import Console
from rich.progress import Progress

ROOT = Path(__file__).parent.parent
_NO_NAMES = ("_", "test_", "conftest")


def names(folder: str) -> list[str]:
    """Names in a folder of `tests`, such as "claims"."""
    return sorted(_homes(folder))


def module(folder: str, name: str) -> ModuleType:
    """The module of a name."""
    return import_module(f"tests.{folder}.{_homes(folder)[name][0]}")


def file(folder: str, name: str) -> Path:
    """The file of a name, which is not imported."""
    return ROOT / "tests" / folder / f"{_homes(folder)[name][0]}.py"


def claim(name: str) -> Any:
    """The claim of a name."""
    return getattr(module("claims", name), _homes("claims")[name][1])


def _homes(folder: str) -> dict[str, tuple[str, str]]:
    """Module and variable of each name."""
    files = [f for f in (ROOT / "tests" / folder).glob("*.py") if not f.stem.startswith(_NO_NAMES)]
    found = [
        (file.stem, "CLAIM", variant)
        for file in files
        for variant in re.findall(r"^CLAIM(\w*) = ", file.read_text("utf-8"), re.M) or [""]
    ]
    return {f"{stem}{v}".lower().replace("_", "-"): (stem, name + v) for stem, name, v in found}


FOLDERS = {"claims": "claims", "bench": "benchmarks", "pictures": "gallery"}
"""Folders of names by the targets of make."""


def is_made(line: str) -> bool:
    """True for a line of make with a target that exists, and a name of its folder."""
    make, target, *variables = line.split("#")[0].split()
    given = dict(word.split("=", 1) for word in variables)
    known = [given["NAME"]] if "NAME" in given else []
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    return (
        make == "make"
        and f"\n{target}: " in makefile
        and all(f"$({name})" in makefile for name in given)
        and set(known) <= set(names(FOLDERS[target]) if known else ())
    )


def chosen(folder: str, given: Sequence[str]) -> list[str]:
    """The names that are given, or all. Ends with status 2 where there is no such name."""
    known = names(folder)
    for name in given:
        if name not in known:
            near = "".join(f" Did you mean {n}?" for n in difflib.get_close_matches(name, known, 1))
            print(f"No {name!r} in {folder}.{near} There are: {', '.join(known)}", file=sys.stderr)
            raise SystemExit(2)
    return list(given or known)


def progress(what: str, total: int) -> tuple[Progress, Callable[[], None]]:
    """A bar on the terminal's stderr, and its step."""
    bar = Progress(console=Console(stderr=True), transient=True)
    task = bar.add_task(what, total=total)
    return bar, lambda: bar.advance(task)

"""What judges the product from outside: claims, benchmarks and pictures, each a file of its folder.

The name of a file is the name: `tests/claims/imu_rest.py` is the claim `imu-rest`. Files that begin
with an underscore are shared, and those that begin with `test_` are tests.
"""

import difflib
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType

from rich.console import Console
from rich.progress import Progress

ROOT = Path(__file__).parent.parent
_NO_NAMES = ("_", "test_", "conftest")


def names(folder: str) -> list[str]:
    """Names in a folder of `tests`, such as "claims"."""
    files = sorted((ROOT / "tests" / folder).glob("*.py"))
    return [file.stem.replace("_", "-") for file in files if not file.stem.startswith(_NO_NAMES)]


def module(folder: str, name: str) -> ModuleType:
    """The module of a name."""
    return import_module(f"tests.{folder}.{name.replace('-', '_')}")


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

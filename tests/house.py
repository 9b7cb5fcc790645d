"""Size and structure of the project, measured: docs/house.md.

    make house                           # writes the page
    python -m tests.house --root DIR     # prints the table of another tree, an older commit say
    python -m tests.house --seconds 540  # with processor seconds of the suite, measured apart

Lines are all lines of Python files, blanks, comments and docstrings among them. A traced run enters
a file with the first call of each of its functions: the stays are the runs of equal files in that
order, the returns those to a file that was left before.
"""

import argparse
import ast
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from scipy.sparse.csgraph import connected_components

PACKAGES = ("assets", "kinematics", "ilc", "sim", "scripts")
EVIDENCE = ("claims", "benchmarks", "contract", "gallery", "calibration")
SMALL = 60
"""Lines below which a file counts as small."""
PAGE = Path(__file__).parents[1] / "docs/house.md"
HEAD = """\
# Size and structure

Written by `make house`. *Before* is the tree of the plan, measured alike; *asked* is that of the
reduction. Lines are all lines of Python files. A traced run enters a file with the first call of
each of its functions.

| read | before | asked | reached |
|---|---|---|---|
"""
PLAN = {
    "lines in the packages; files": ("77,880; 787", "60,000; 520"),
    "files below 60 lines; files that one other file imports": ("226; 273", "60; 90"),
    "default `armside laser`: files entered, stays, returns": ("102, 272, 170", "60, 160, 90"),
    "`learn` by motors from Python: files, modules loaded": ("56, 237", "35, 90"),
    "rooms, arrows in sim; in scripts": ("29, 115; 15, 38", "20, 80; 10, 30"),
    "circles of files": ("2", "0"),
    "names that are public; declared": ("2,250; 0", "about 120 declared"),
    "class names, file names that stand for several": ("51; 92", "0; 15"),
    "lines of tests; of evidence; processor seconds of the suite": (
        "45,966; 0; 950",
        "36,000; 6,000; 600",
    ),
    "words of README and docs; of guides": ("77,491; not measured", "-; 35,000"),
}
"""What was read, before the rooms were joined, and what was asked."""
RECORDS = (
    "errata",
    "faults",
    "findings",
    "house",
    "mutation",
    "papers",
    "peers",
    "suite",
    "thesis",
)
"""Pages of docs/ that list evidence; those in folders of docs/ are no guides either."""

TRACE = """
import os, sys, threading, time
root = os.environ["ROOT"]
ours = tuple(os.path.join(root, name, "") for name in {packages})
seen, order = set(), []
def called(frame, event, _):
    code = frame.f_code
    file = os.path.realpath(code.co_filename)
    key = (file, code.co_firstlineno)
    if event == "call" and file.startswith(ours) and code.co_name != "<module>" and key not in seen:
        seen.add(key)
        order.append(file)
def run():
{run}
run() if {twice} else None
threading.setprofile(called)
sys.setprofile(called)
run()
sys.setprofile(None)
stays = sum(a != b for a, b in zip([None, *order], order))
modules = sum(name.partition(".")[0] == "armside" for name in sys.modules)
print(len(set(order)), stays, stays - len(set(order)), modules, file=sys.stderr)
"""
LASER = """
    from armside.scripts.cli import main
    main(["laser", "--quiet", "--out", f"{os.environ['TMP']}/{time.time_ns()}"])
"""
LEARN = """
    from {place} import Cut, learn
    list(learn(Cut(), seed=0))
"""


def python_files(folder: Path) -> list[Path]:
    """Python files below a folder, in order."""
    return sorted(folder.rglob("*.py"))


def source(file: Path) -> str:
    """Text of a module, with that of the stub by which a package hands on names lazily."""
    parts = (each for each in (file, file.with_suffix(".pyi")) if each.exists())
    return "\n".join(part.read_text(encoding="utf-8") for part in parts)


def lines(files: list[Path]) -> int:
    """All lines of the files."""
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


class House:
    """A tree of the project."""

    def __init__(self, root: Path, packages: Sequence[str] = PACKAGES) -> None:
        self.root = root
        self.files = [file for name in packages for file in python_files(root / name)]
        self.trees = {f: ast.parse(source(f)) for f in self.files}
        self.module = {self._name(file): file for file in self.files}
        self.imported = {file: set(self._imported(file)) for file in self.files}
        """Full names of modules, ours and of others, anywhere in a file."""
        self.imports = {
            file: {self.module[name] for name in names if name in self.module} - {file}
            for file, names in self.imported.items()
        }

    def _name(self, file: Path) -> str:
        parts = ("armside", *file.relative_to(self.root).with_suffix("").parts)
        return ".".join(parts).removesuffix(".__init__")

    def _imported(self, file: Path) -> Iterator[str]:
        """Names that a file imports, relative ones resolved; ours down to the module."""
        name = self._name(file).split(".")
        inside = name if file.name == "__init__.py" else name[:-1]
        for node in ast.walk(self.trees[file]):
            if isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                above = inside[: len(inside) + 1 - node.level] if node.level else []
                source = ".".join([*above, *([node.module] if node.module else [])])
                for alias in node.names:
                    full = f"{source}.{alias.name}"
                    yield full if full in self.module or source == "armside" else source

    @property
    def small(self) -> list[Path]:
        """Files with few lines."""
        return [f for f in self.files if lines([f]) < SMALL]

    @property
    def imported_once(self) -> list[Path]:
        """Files that exactly one other file imports."""
        importers = Counter(target for targets in self.imports.values() for target in targets)
        return [f for f in self.files if f.name != "__init__.py" and importers[f] == 1]

    def rooms(self, package: str) -> dict[str, set[str]]:
        """Rooms of a package, the package's own names among them, and those that each imports."""
        found: dict[str, set[str]] = defaultdict(set)
        for file, targets in self.imports.items():
            if file.is_relative_to(self.root / package):
                room = self.room(file)
                inside = {t for t in targets if t.is_relative_to(self.root / package)}
                found[room] |= set(map(self.room, inside)) - {room}
        return found

    def room(self, file: Path) -> str:
        """A sub-package, or a module that stands at the top of a package."""
        return ".".join(self._name(file).split(".")[:3])

    def circles(self) -> list[list[Path]]:
        """Files that import each other, directly or through others: one list a circle."""
        index = {file: i for i, file in enumerate(self.files)}
        arrows = [(index[a], index[b]) for a, targets in self.imports.items() for b in targets]
        graph = np.zeros((len(self.files), len(self.files)), dtype=bool)
        graph[tuple(np.array(arrows).T)] = True
        n, of = connected_components(graph, connection="strong")
        members = [[f for f, c in zip(self.files, of, strict=True) if c == i] for i in range(n)]
        return [each for each in members if len(each) > 1]

    @property
    def defined(self) -> list[tuple[str, str, Path]]:
        """Kind, name and file of what modules define at their top level."""
        found = []
        for file, tree in self.trees.items():
            for node in tree.body:
                if isinstance(node, ast.ClassDef):
                    found.append(("class", node.name, file))
                elif isinstance(node, ast.FunctionDef):
                    found.append(("function", node.name, file))
                elif isinstance(node, (ast.Assign, ast.AnnAssign)):
                    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                    found += [("value", t.id, file) for t in targets if isinstance(t, ast.Name)]
        return found

    def public(self) -> int:
        """Classes and functions at the top of a module whose names have no underscore."""
        return sum(kind != "value" and not name.startswith("_") for kind, name, _ in self.defined)

    def ambiguous(self) -> tuple[int, int]:
        """Names of classes, and of files, that stand for several."""
        classes = Counter(name for kind, name, _ in self.defined if kind == "class")
        names = Counter(f.name for f in self.files if f.name != "__init__.py")
        return sum(n > 1 for n in classes.values()), sum(n > 1 for n in names.values())

    def traced(self, run: str, *, twice: bool) -> list[int]:
        """Files entered, stays, returns, modules loaded by a run; after a first run if twice."""
        with tempfile.TemporaryDirectory() as folder:
            found = subprocess.run(
                [sys.executable, "-c", TRACE.format(packages=PACKAGES, run=run, twice=twice)],
                env=os.environ
                | {"PYTHONPATH": str(self.root / "src"), "ROOT": str(self.root), "TMP": folder},
                capture_output=True,
                text=True,
                check=True,
                cwd=folder,
            )
        return [int(word) for word in found.stderr.split()[-4:]]

    def words(self) -> tuple[int, int]:
        """Words of the README and of all pages of the docs, and of those that are guides."""
        docs = self.root / "docs"
        count = {
            page: len(page.read_text(encoding="utf-8").split())
            for page in (self.root / "README.md", *docs.rglob("*.md"))
        }
        guides = (n for page, n in count.items() if page.parent in (self.root, docs))
        records = sum(count.get(docs / f"{name}.md", 0) for name in RECORDS)
        return sum(count.values()), sum(guides) - records

    def declared(self) -> int:
        """Names that the stubs of `armside` and of its packages hand on."""
        stubs = [self.root / "src/armside/__init__.pyi"]
        stubs += [self.root / name / "__init__.pyi" for name in PACKAGES]
        found = set[str]()
        for stub in stubs:
            if stub.exists():
                found |= set(re.findall(r"import \w+ as (\w+)", stub.read_text(encoding="utf-8")))
        return len(found)


def rows(root: Path, seconds: str, *, trace: bool) -> list[tuple[str, str]]:
    """What was read, and its value."""
    house = House(root)
    evidence = [f for name in EVIDENCE for f in python_files(root / "tests" / name)]
    tests = [f for f in python_files(root / "tests") if f not in evidence]
    small, once = house.small, house.imported_once
    sim, scripts = (
        f"{len(found)}, {sum(map(len, found.values()))}"
        for found in (house.rooms("sim"), house.rooms("scripts"))
    )
    classes, names = house.ambiguous()
    found = [
        ("lines in the packages; files", f"{lines(house.files)}; {len(house.files)}"),
        (
            f"files below {SMALL} lines; files that one other file imports",
            f"{len(small)}; {len(once)} ({lines(once)} lines)",
        ),
        ("rooms, arrows in sim; in scripts", f"{sim}; {scripts}"),
        ("circles of files", str(len(house.circles()))),
        ("names that are public; declared", f"{house.public()}; {house.declared()}"),
        ("class names, file names that stand for several", f"{classes}; {names}"),
        (
            "lines of tests; of evidence; processor seconds of the suite",
            f"{lines(tests)}; {lines(evidence)}; {seconds}",
        ),
        ("words of README and docs; of guides", "{}; {}".format(*house.words())),
    ]
    if trace:
        place = "armside" if house.declared() else "armside.sim.laser"
        laser = house.traced(LASER, twice=True)
        learn = house.traced(LEARN.format(place=place), twice=True)
        found[2:2] = [
            (
                "default `armside laser`: files entered, stays, returns",
                ", ".join(map(str, laser[:3])),
            ),
            (
                "`learn` by motors from Python: files, modules loaded",
                f"{learn[0]}, {learn[3]}",
            ),
        ]
    return found


def main() -> None:
    """Write the page, or print the table of another tree."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path)
    parser.add_argument("--seconds", default="not measured")
    parser.add_argument("--no-trace", action="store_true")
    given = parser.parse_args()
    root = PAGE.parents[1] if given.root is None else given.root.resolve()
    found = rows(root, given.seconds, trace=not given.no_trace)
    lines = [f"| {name} | {' | '.join(PLAN[name])} | {value} |\n" for name, value in found]
    if given.root is None:
        PAGE.write_text(HEAD + "".join(lines), encoding="utf-8")
    print(HEAD + "".join(lines), end="")


if __name__ == "__main__":
    main()

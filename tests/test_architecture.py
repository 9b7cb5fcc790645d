"""Arrows between packages point downwards, and rooms inside a package have no circle.

A room is a sub-package, or a module that stands at the top of a package.
"""

import ast
import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).parent.parent
MAY_IMPORT = {
    "assets": set(),
    "kinematics": set(),
    "ilc": set(),
    "sim": {"assets", "kinematics", "ilc"},
    "scripts": {"assets", "kinematics", "ilc", "sim"},
}
OURS = sorted(MAY_IMPORT)
EVERYWHERE = {"arrays"}
"""Modules of `armside` itself, for all packages."""
FOREIGN_AND_FORBIDDEN = {"ilc": {"mujoco"}, "kinematics": {"mujoco"}, "assets": {"mujoco", "numpy"}}
GYMNASIUM = {"sim/tuning/registration.py"}
"""Gymnasium keeps the classes of an env as strings, so that a spec can be written to a file."""

MODULES = {
    ".".join(("armside", *file.relative_to(ROOT).with_suffix("").parts)).removesuffix(
        ".__init__"
    ): file
    for package in OURS
    for file in (ROOT / package).rglob("*.py")
}


def imported(module: str) -> Iterator[str]:
    """Full names that a module imports, relative ones resolved; ours down to the module.

    What a package hands on lazily, by a stub beside it, counts as imported.
    """
    file = MODULES[module]
    inside = module.split(".") if file.name == "__init__.py" else module.split(".")[:-1]
    text = "\n".join(
        each.read_text(encoding="utf-8")
        for each in (file, file.with_suffix(".pyi"))
        if each.exists()
    )
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = inside[: len(inside) + 1 - node.level] if node.level else []
            source = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                full = f"{source}.{alias.name}"
                yield full if full in MODULES or source == "armside" else source


def room(module: str) -> str:
    return ".".join(module.split(".")[:3])


def rooms(package: str) -> dict[str, set[str]]:
    """Room: the rooms of the same package that it imports. The package's own names are a room."""
    graph: dict[str, set[str]] = {}
    for module in MODULES:
        if module.split(".")[1] == package:
            targets = {room(name) for name in imported(module) if name in MODULES}
            ours = {name for name in targets if name.split(".")[1] == package}
            graph.setdefault(room(module), set()).update(ours - {room(module)})
    return graph


@pytest.mark.parametrize("package", OURS)
def test_imports_point_downwards(package):
    allowed = MAY_IMPORT[package] | EVERYWHERE | {package}
    foreign = FOREIGN_AND_FORBIDDEN.get(package, set())
    for module, file in MODULES.items():
        if module.split(".")[1] == package:
            names = [name.split(".") for name in imported(module)]
            ours = {parts[1] for parts in names if parts[0] == "armside" and parts[1:]}
            wrong = (ours - allowed) | ({parts[0] for parts in names} & foreign)
            assert not wrong, f"{file.relative_to(ROOT)} imports {sorted(wrong)}"


def test_files_have_no_circle():
    """Imports inside functions count: they hide a circle and do not break it."""
    number = {module: i for i, module in enumerate(MODULES)}
    arrows = np.zeros((len(number), len(number)))
    for module, i in number.items():
        arrows[i, [number[name] for name in imported(module) if name in number]] = 1.0
    _, circle = connected_components(csr_array(arrows), connection="strong")
    members = [[m for m, i in number.items() if circle[i] == c] for c in np.unique(circle)]
    assert not [each for each in members if len(each) > 1]


@pytest.mark.parametrize("package", OURS)
def test_rooms_have_no_circle(package):
    try:
        TopologicalSorter(rooms(package)).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_functions_are_imported_and_not_named_by_strings():
    """A rename and a type check see an import."""
    named = re.compile(r"[\"']armside[\w.]*:\w+[\"']")
    found = {
        file.relative_to(ROOT).as_posix()
        for file in MODULES.values()
        if named.search(file.read_text(encoding="utf-8"))
    }
    assert found == GYMNASIUM


def test_imports_are_resolved_as_python_does():
    assert {"armside.sim.laser.experiment", "armside.kinematics", "numpy"} <= {
        name for module in MODULES for name in imported(module)
    }
    assert "armside.ilc.laws" in rooms("ilc")["armside.ilc"]
    assert room("armside.sim.robot.model") == room("armside.sim.robot") == "armside.sim.robot"
    assert room("armside.sim.cell") == "armside.sim.cell"

"""Arrows between packages point downwards, and rooms inside a package have no circle.

A room is a sub-package, or a module that stands at the top of a package.
"""

import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from tests.house import House

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

HOUSE = House(ROOT)


@pytest.mark.parametrize("package", OURS)
def test_imports_point_downwards(package):
    allowed = MAY_IMPORT[package] | EVERYWHERE | {package}
    foreign = FOREIGN_AND_FORBIDDEN.get(package, set())
    for file, found in HOUSE.imported.items():
        if file.is_relative_to(ROOT / package):
            names = [name.split(".") for name in found]
            ours = {parts[1] for parts in names if parts[0] == "armside" and parts[1:]}
            wrong = (ours - allowed) | ({parts[0] for parts in names} & foreign)
            assert not wrong, f"{file.relative_to(ROOT)} imports {sorted(wrong)}"


def test_files_have_no_circle():
    """Imports inside functions count: they hide a circle and do not break it."""
    assert HOUSE.circles() == []


@pytest.mark.parametrize("package", OURS)
def test_rooms_have_no_circle(package):
    try:
        TopologicalSorter(HOUSE.rooms(package)).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_functions_are_imported_and_not_named_by_strings():
    """A rename and a type check see an import."""
    named = re.compile(r"[\"']armside[\w.]*:\w+[\"']")
    found = {
        file.relative_to(ROOT).as_posix()
        for file in HOUSE.files
        if named.search(file.read_text(encoding="utf-8"))
    }
    assert found == GYMNASIUM


def test_imports_are_resolved_as_python_does():
    """What a package hands on lazily, by a stub beside it, counts as imported."""
    assert {"armside.sim.laser.experiment", "armside.kinematics", "numpy"} <= set().union(
        *HOUSE.imported.values()
    )
    assert "armside.ilc.laws" in HOUSE.rooms("ilc")["armside.ilc"]
    rooms = {HOUSE.room(ROOT / "sim" / file) for file in ("robot/model.py", "robot/__init__.py")}
    assert rooms == {"armside.sim.robot"}
    assert HOUSE.room(ROOT / "sim/cell.py") == "armside.sim.cell"

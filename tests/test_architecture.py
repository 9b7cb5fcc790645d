"""The house has three floors and no arrow back up."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
OURS = {"assets", "kinematics", "ilc", "sim", "scripts"}
MAY_IMPORT = {
    "assets": set(),
    "kinematics": set(),
    "ilc": set(),
    "sim": {"assets", "kinematics", "ilc"},
    "scripts": {"assets", "kinematics", "ilc", "sim"},
}
FOREIGN_AND_FORBIDDEN = {"ilc": {"mujoco"}, "kinematics": {"mujoco"}, "assets": {"mujoco", "numpy"}}


def imported_packages(file: Path) -> set[str]:
    """Top-level names a module imports; relative imports stay inside and do not count."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.add(node.module.split(".")[0])
    return names


@pytest.mark.parametrize("package", sorted(OURS))
def test_imports_point_downwards(package):
    forbidden = (OURS - MAY_IMPORT[package] - {package}) | FOREIGN_AND_FORBIDDEN.get(package, set())
    for file in sorted((ROOT / package).rglob("*.py")):
        wrong = imported_packages(file) & forbidden
        assert not wrong, f"{file.relative_to(ROOT)} imports {sorted(wrong)}"

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
    """Our packages and foreign top-level names that a module imports absolutely."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            names |= {_first(alias.name) for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            from_root = node.module == "armside"
            names |= {a.name for a in node.names} if from_root else {_first(node.module)}
    return names


def _first(module: str) -> str:
    return module.removeprefix("armside.").split(".")[0]


@pytest.mark.parametrize("package", sorted(OURS))
def test_imports_point_downwards(package):
    forbidden = (OURS - MAY_IMPORT[package] - {package}) | FOREIGN_AND_FORBIDDEN.get(package, set())
    for file in sorted((ROOT / package).rglob("*.py")):
        wrong = imported_packages(file) & forbidden
        assert not wrong, f"{file.relative_to(ROOT)} imports {sorted(wrong)}"

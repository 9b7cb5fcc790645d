"""The declared surface: stubs, what is imported, its page, and what the other pages import."""

import ast
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from tests.test_docs import blocks

from armside.scripts.shell import interrupts, runner

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "surface.md"
STABLE = ROOT / "docs" / "stable.md"
FOLDERS = {
    "armside": ROOT / "src" / "armside",
    "armside.ilc": ROOT / "ilc",
    "armside.kinematics": ROOT / "kinematics",
    "armside.sim": ROOT / "sim",
}
"""Packages that hand on names by a stub."""
LINE = re.compile(r"from \.[\w.]* import (\w+) as \1")
OTHERS = {"learn"}
"""Names that stand for another thing in a package than in `armside`."""
DEEPER = {
    "choose-a-law.md": "bases of the law with basis functions",
    "composed_laws.py": "the parts that laws are composed of",
    "formats.md": "the command line from Python, to have a run",
    "identification.md": "the page on methods of identification",
    "toolbox.md": "the page on symbolic kinematics and generated code",
    "tuning.md": "the adapter to Stable-Baselines3",
}
"""Pages and examples that import from deeper than what is declared, and what for."""


def declared(package: str) -> list[str]:
    """Names in the stub of a package."""
    text = (FOLDERS[package] / "__init__.pyi").read_text(encoding="utf-8")
    return [found[1] for line in text.splitlines() if (found := LINE.fullmatch(line))]


def homes() -> set[tuple[str, str]]:
    """Flattest package and name of all that is declared."""
    flat = set(declared("armside"))
    inner = {(package, name) for package in FOLDERS for name in declared(package)}
    return {(p, name) for p, name in inner if p == "armside" or name not in flat - OTHERS} - {
        ("armside.sim", name) for name in OTHERS
    }


def imports(text: str) -> set[tuple[str, str]]:
    """Module and name of what code imports from our packages."""
    return {
        (node.module, alias.name)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "armside"
        for alias in node.names
        if node.module is not None
    }


def code(file: Path) -> str:
    """Python in a page, that which is only shown too, or a file of it."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        return text
    shown = re.compile(r"^from armside", re.MULTILINE)
    return "\n".join(
        block.text
        for block in blocks(text)
        if block.language == "python" or (block.language == "text" and shown.search(block.text))
    )


@pytest.mark.parametrize("package", FOLDERS)
def test_a_stub_lists_each_name_once_and_each_resolves(package):
    names = declared(package)
    text = (FOLDERS[package] / "__init__.pyi").read_text(encoding="utf-8")
    assert len(names) == len(text.splitlines()) == len(set(names))
    module = import_module(package)
    assert sorted(names) == module.__all__ == dir(module)
    for name in names:
        assert getattr(module, name) is not None


def test_a_name_of_two_levels_is_one_thing():
    flat = import_module("armside")
    for package in ("armside.ilc", "armside.kinematics", "armside.sim"):
        for name in set(declared(package)) & set(declared("armside")):
            same = getattr(import_module(package), name) is getattr(flat, name)
            assert same is (package != "armside.ilc" or name not in OTHERS), name


def test_the_surface_is_about_120_names():
    assert len({name for _, name in homes()}) <= 130


def test_a_name_that_is_not_declared_is_no_attribute():
    with pytest.raises(AttributeError, match="Curt"):
        import_module("armside").Curt  # noqa: B018


def test_the_page_has_an_example_of_each_name_and_no_other():
    text = code(PAGE)
    packages = {("armside", name) for name in ("assets", "ilc", "kinematics", "sim")}
    assert imports(text) | packages == homes()
    used = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    names = {
        alias.asname or alias.name
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("armside")
        for alias in node.names
    }
    assert names <= used
    assert {name for _, name in packages} <= set(re.findall(r"armside\.(\w+)\.", text))


PAGES = [
    ROOT / "README.md",
    *(page for page in sorted((ROOT / "docs").glob("*.md")) if page != PAGE),
    *sorted((ROOT / "docs" / "examples").glob("*.py")),
]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_and_examples_import_declared_names(page):
    handed_on = {(package, name) for package in FOLDERS for name in declared(package)}
    deeper = imports(code(page)) - handed_on
    assert bool(deeper) == (page.name in DEEPER), deeper
    assert not {(module, name) for module, name in deeper if module in FOLDERS}, "unknown names"
    there = {(package, name) for package, name in handed_on if package != "armside"}
    packages = {".".join(module.split(".")[:2]) for module, _ in deeper}
    hidden = {(module, name) for module, name in deeper for p in packages if (p, name) in there}
    assert not hidden, "declared, and imported from deeper"


def test_envs_and_exit_statuses_of_the_page_on_what_is_stable_are_those_of_the_code():
    text = STABLE.read_text(encoding="utf-8")
    gymnasium = import_module("gymnasium")
    import_module("armside")
    assert {"armside/" + name for name in re.findall(r"`armside/([\w-]+)`", text)} == {
        name for name in gymnasium.registry if name.startswith("armside/")
    }
    statuses = re.search(r"0 done, (\d+) failed while running, (\d+) bad input, (\d+) int", text)
    assert statuses
    assert tuple(map(int, statuses.groups())) == (
        runner.FAILED,
        runner.BAD_INPUT,
        interrupts.INTERRUPTED,
    )


def test_armside_loads_neither_mujoco_nor_a_package_of_its_own_until_they_are_used():
    code = "import armside, sys; print(*(n for n in sys.modules if n.startswith('armside.')))"
    code += "; print('mujoco' in sys.modules, 'numba' in sys.modules, 'scipy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["armside.gymnasium_hook", "False", "False", "False"]


def test_a_flat_name_loads_only_what_it_needs():
    code = "import sys; from armside import Robot; print('mujoco' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False"]

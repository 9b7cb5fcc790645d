"""An installation from a wheel is complete and works away from the checkout.

Here the clean environment borrows the dependencies of this one, to be quick; CI installs them
afresh. That every import is a declared dependency is checked by name in both.
"""

import ast
import json
import os
import re
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
OURS = ("assets", "ilc", "kinematics", "scripts", "sim")
"""Folders at the root, linked from `src/armside`."""
CITATION = ROOT / "CITATION.cff"
CI = bool(os.environ.get("ARMSIDE_CI"))
ESTIMATED = 'measure="estimate", '
PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]


def packaged_files() -> set[str]:
    """Every file of our packages, as it is named inside a wheel."""
    src = ROOT / "src" / "armside"
    linked = [path for package in OURS for path in (src / package).rglob("*")]
    return {
        path.relative_to(src.parent).as_posix()
        for path in [*src.iterdir(), *linked]
        if path.is_file() and "__pycache__" not in path.parts
    }


@pytest.fixture(scope="module")
def wheel(made_once) -> Path:
    folder = made_once("wheel", lambda folder: build_wheel(ROOT, folder))
    (file,) = folder.glob("armside-*.whl")
    return file


def build_wheel(source: Path, folder: Path) -> Path:
    build = [*PIP, "wheel", "--no-deps", "--no-build-isolation", "--no-cache-dir"]
    subprocess.run([*build, "--wheel-dir", folder, source], check=True)
    (file,) = folder.glob("armside-*.whl")
    return file


class Installed(NamedTuple):
    """An environment where nothing but the wheel is installed."""

    bin: Path
    gained: set[str]
    """Names in site-packages that the wheel added."""


@pytest.fixture(scope="module")
def installed(wheel, made_once) -> Installed:
    folder = made_once("clean", lambda folder: install(wheel, folder))
    return Installed(folder / "env" / "bin", set((folder / "gained").read_text().splitlines()))


def install(wheel: Path, folder: Path) -> None:
    """Make an environment of the wheel, and write down what it gained."""
    env = folder / "env"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", env], check=True)
    python = env / "bin" / "python"
    site = Path(sysconfig.get_paths(vars={"base": str(env), "platbase": str(env)})["purelib"])
    install = [*PIP, "--python", python, "install"]
    if CI:
        subprocess.run([*install, wheel], check=True)
        subprocess.run([*install[:-1], "uninstall", "--yes", "armside"], check=True)
    else:
        # Files of this environment only: its own links to the checkout are not followed.
        borrowed = site / "borrowed_dependencies.pth"
        borrowed.write_text(sysconfig.get_path("purelib") + "\n")
    before = set(os.listdir(site))
    subprocess.run([*install, "--no-deps", "--force-reinstall", wheel], check=True)
    (folder / "gained").write_text("\n".join(set(os.listdir(site)) - before))


def run_outside(command: list, folder: Path) -> str:
    env = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        command, cwd=folder, env=env, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_holds_every_file_of_our_packages_and_nothing_else(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    inside = {name for name in names if not name.split("/")[0].endswith(".dist-info")}
    assert inside == packaged_files()


def test_the_wheel_holds_type_markers_robots_and_licence(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    assert "armside/py.typed" in names
    assert any(name.startswith("armside/assets/") and name.endswith(".xml") for name in names)
    assert any(name.endswith("/licenses/LICENSE") for name in names)


def test_the_archive_of_the_sources_builds_the_same_wheel(wheel, tmp_path):
    build = [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", tmp_path]
    subprocess.run(build, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    (archive,) = tmp_path.glob("armside-*.tar.gz")
    ours, theirs = (zipfile.ZipFile(file) for file in (wheel, build_wheel(archive, tmp_path)))
    assert {i.filename: i.CRC for i in ours.infolist()} == {
        i.filename: i.CRC for i in theirs.infolist()
    }


def test_an_environment_gains_one_name_and_its_metadata(installed):
    assert installed.gained == {"armside", f"armside-{PROJECT['version']}.dist-info"}


def test_the_installed_command_knows_its_version(installed, tmp_path):
    for command in (["armside"], ["python", "-m", "armside"]):
        words = [installed.bin / command[0], *command[1:], "--version"]
        assert run_outside(words, tmp_path) == f"armside {PROJECT['version']}\n"


def test_what_is_imported_is_what_was_installed(installed, tmp_path):
    files = ", ".join(f"{name}.__file__" for name in OURS)
    code = f"from armside import {', '.join(OURS)}; print({files})"
    for file in run_outside([installed.bin / "python", "-c", code], tmp_path).split():
        assert Path(file).is_relative_to(installed.bin.parent)


def test_the_lines_of_the_readme_run_beside_packages_of_the_users_own(installed, tmp_path):
    """Saved as `sim.py`, in a folder that has an `assets` and a `scripts` as well."""
    found = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.M | re.S)
    lines = "".join(found)
    if not CI:  # identifying springs is run by test_docs.py
        assert ESTIMATED in lines
        lines = lines.replace(ESTIMATED, "")
    (tmp_path / "sim.py").write_text(lines)
    for name in ("assets", "scripts"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise ImportError('of the user')\n")
    printed = run_outside([installed.bin / "python", "sim.py"], tmp_path)
    assert len(printed.splitlines()) == 6


@pytest.mark.parametrize("first", ["import gymnasium", "import armside, gymnasium"])
def test_gymnasium_finds_the_env_from_its_name(installed, tmp_path, first):
    code = f"""{first}
name = "armside:armside/IlcTuning-v0"
print(gymnasium.make(name).spec.id, gymnasium.make_vec(name, num_envs=2).num_envs)
print(gymnasium.make("armside/IlcTuning-v0").spec.id)"""
    printed = run_outside([installed.bin / "python", "-c", code], tmp_path)
    assert printed.split() == ["armside/IlcTuning-v0", "2", "armside/IlcTuning-v0"]


def test_an_experiment_runs_outside_the_checkout(installed, tmp_path):
    command = [installed.bin / "armside", "laser", "--iterations", "1", "--json", "--out", "here"]
    summary = json.loads(run_outside(command, tmp_path))
    assert [row["k"] for row in summary["iterations"]] == [0, 1]
    assert json.loads((tmp_path / "here" / "summary.json").read_text()) == summary
    assert (tmp_path / "here" / "circles.png").stat().st_size > 0
    stable = re.findall(r"`(\w+\.(?:json|parquet|toml))`", (ROOT / "docs/stable.md").read_text())
    assert len(stable) == 3
    assert all((tmp_path / "here" / name).stat().st_size > 0 for name in stable)


def third_party_imports() -> dict[str, str]:
    """Top-level module: a file of ours that imports it, outside `scripts/thesis/peers.py`."""
    found: dict[str, str] = {}
    for name in sorted(packaged_files()):
        if not name.endswith(".py") or name == "armside/scripts/thesis/peers.py":
            continue
        for node in ast.walk(ast.parse((ROOT / "src" / name).read_text())):
            modules = []
            if isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                modules = [node.module]
            for module in modules:
                found.setdefault(module.split(".")[0], name)
    known = set(sys.stdlib_module_names) | {"armside"}
    return {module: file for module, file in found.items() if module not in known}


BROUGHT = {"torch": "stable-baselines3", "sqlalchemy": "optuna", "pinocchio": "pin"}
"""Module: the declared package that brings it and hands us its objects."""


def test_every_import_is_a_declared_dependency():
    """Or an extra's; such a module is imported by a function, when it is needed."""
    extras = PROJECT["optional-dependencies"]
    named = [
        *PROJECT["dependencies"],
        *(r for name in extras if name != "test" for r in extras[name]),
    ]
    declared = {re.split(r"[\[<>=!~ ;]", requirement)[0].lower() for requirement in named}
    distributions = packages_distributions()
    for module, file in third_party_imports().items():
        names = distributions.get(module, [module.replace("_", "-")])
        owners = {name.lower() for name in names} | {BROUGHT.get(module, "")}
        assert owners & declared, f"{file} imports {module}, which pyproject.toml does not name"


def test_every_dependency_has_a_lower_and_an_upper_bound():
    for requirement in PROJECT["dependencies"]:
        assert ">=" in requirement, requirement
        assert "<" in requirement, requirement


def test_changelog_citation_and_package_agree_on_version_and_date():
    headings = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    known = [re.fullmatch(r"\[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)", h) for h in headings]
    versions = [match[1] for match in known if match]
    assert len(versions) == len(set(versions)) == len(headings) - ("[Unreleased]" in headings)
    cited = dict(
        re.findall(r"^(version|date-released): (\S+)$", CITATION.read_text(), re.MULTILINE)
    )
    newest = next(match for match in known if match)
    assert cited == {"version": newest[1], "date-released": newest[2]}
    assert newest[1] == PROJECT["version"]


RUNNING = "{}.{}".format(*sys.version_info)
LEAST = PROJECT["requires-python"].removeprefix(">=")
CLASSIFIERS = {
    "Development Status :: 3 - Alpha": PROJECT["version"].startswith("0."),
    "Environment :: Console": "armside" in PROJECT["scripts"],
    "Intended Audience :: Science/Research": (ROOT / "docs" / "thesis.md").is_file(),
    "Operating System :: POSIX :: Linux": "apt-get" in (ROOT / ".ci" / "run").read_text(),
    "Programming Language :: Python :: 3 :: Only": LEAST.startswith("3."),
    f"Programming Language :: Python :: {LEAST}": RUNNING == LEAST or not CI,
    "Topic :: Scientific/Engineering :: Physics": "mujoco" in "".join(PROJECT["dependencies"]),
    "Typing :: Typed": (ROOT / "src" / "armside" / "py.typed").is_file(),
}
"""What is claimed of the package, and why it is true: CI runs on Linux, with the oldest Python."""


def test_each_classifier_is_true_and_only_what_ci_runs_is_claimed():
    assert dict.fromkeys(PROJECT["classifiers"], True) == CLASSIFIERS
    assert not any(name.startswith("License") for name in CLASSIFIERS)  # `license` says it


def release(folder: Path) -> subprocess.CompletedProcess:
    """`make release` in a clone, with programs that write down how they are called."""
    bins = folder / ".venv" / "bin"
    bins.mkdir(parents=True, exist_ok=True)
    (bins / "python").write_text('#!/bin/sh\necho "$*" >> called\n')
    (bins / "python").chmod(0o755)
    for name in (".installed", ".installed-release"):
        (folder / ".venv" / name).touch()
    return subprocess.run(
        ["make", "release"], cwd=folder, capture_output=True, text=True, check=False
    )


def test_a_release_is_made_of_a_clean_tree_whose_changelog_names_the_version(tmp_path):
    git = ["git", "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=a@b.example"]
    for name in ("Makefile", "pyproject.toml", "CHANGELOG.md"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    (tmp_path / ".gitignore").write_text(".venv\ncalled\n")
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "all"]):
        subprocess.run([*git, *words], check=True)
    assert release(tmp_path).returncode == 0
    called = (tmp_path / "called").read_text()
    assert re.search(r"-m build\n.*-m twine check --strict dist/", called, re.DOTALL)
    (tmp_path / "CHANGELOG.md").write_text("## [Unreleased]\n")
    assert "commit them first" in release(tmp_path).stderr
    subprocess.run([*git, "commit", "-qam", "unreleased"], check=True)
    assert f"no heading '## [{PROJECT['version']}] - DATE'" in release(tmp_path).stderr
    assert (tmp_path / "called").read_text() == called

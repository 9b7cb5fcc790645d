"""Shared by all tests: programs and graphics that a bare machine may lack."""

import fcntl
import importlib.util
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

# Before NumPy is imported, here and in the workers of pytest-xdist: threads of BLAS that wait for a
# busy core make small matrices a thousand times slower.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# CI asks whether a change is sound, and the same change gets the same answer; whoever works on it
# draws new examples with every run.
settings.load_profile("ci" if os.environ.get("ARMSIDE_CI") else "default")


SLOWEST = (
    "README.md",
    "test_claim_holds_for_one_seed_at_one_pose",
    "docs/twin.md",
    "test_300_command_lines",
    "docs/estimation.md",
    "test_packaging.py",
    "test_arm_side.py",
    "test_docs.py",
    "test_replay.py",
)
"""Parts of the names of the tests and set-ups that take longest, the longest first."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the slowest tests first: workers share the rest, and none ends alone with a long test."""

    def place(item: pytest.Item) -> int:
        return next((i for i, name in enumerate(SLOWEST) if name in item.nodeid), len(SLOWEST))

    items.sort(key=place)


@pytest.fixture(scope="session")
def made_once(tmp_path_factory, worker_id):
    """A function that gives a folder of a name, made once for all workers of pytest-xdist.

    It is called with the name and with what makes the folder: a function of its path.
    """
    own = tmp_path_factory.getbasetemp()
    shared = own if worker_id == "master" else own.parent

    def folder(name: str, make: Callable[[Path], None]) -> Path:
        done = shared / f"once-{name}"
        with (shared / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (done / "made").exists():
                shutil.rmtree(done, ignore_errors=True)
                make(done)
                (done / "made").touch()
        return done

    return folder


@pytest.fixture
def require_program():
    """A function that skips the test when a program is missing, or fails it under ARMSIDE_CI."""

    def require(*names: str) -> str:
        for name in names:
            if path := shutil.which(name):
                return path
        message = f"needs the program {' or '.join(names)}"
        if os.environ.get("ARMSIDE_CI"):
            pytest.fail(f"{message}; .ci/run must install it")
        pytest.skip(message)

    return require


@pytest.fixture
def graphics():
    """Skips the test, or fails it under ARMSIDE_CI, where OpenGL does not draw."""
    import mujoco

    from armside.sim.replay.offscreen import NoGraphicsError, Offscreen

    try:
        with Offscreen(mujoco.MjModel.from_xml_string("<mujoco/>"), 8, 8):
            pass
    except NoGraphicsError as error:
        if os.environ.get("ARMSIDE_CI"):
            pytest.fail(str(error))
        pytest.skip("needs the library libEGL")


@pytest.fixture(scope="session")
def scenes():
    """Module of the synthetic recordings of an arm in motion."""
    file = Path(__file__).parent / "sim" / "gears" / "synthetic.py"
    spec = importlib.util.spec_from_file_location("synthetic", file)
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules["synthetic"] = module
    spec.loader.exec_module(module)
    return module

"""Shared by all tests: programs and graphics that a bare machine may lack."""

import fcntl
import gc
import importlib
import os
import shutil
import signal
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from hypothesis import settings

# Before NumPy is imported, here and in the workers of pytest-xdist: threads of BLAS that wait for a
# busy core make small matrices a thousand times slower.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A job in the background and one below nohup ignore signals, and so would all processes that tests
# start. A signal that a handler drops is as good as ignored here, and has its default there.
DROPPED = os.environ.setdefault(
    "ARMSIDE_TESTS_DROP",  # for the workers of pytest-xdist
    " ".join(
        str(int(number))
        for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM)
        if signal.getsignal(number) is signal.SIG_IGN
    ),
)
for number in map(int, DROPPED.split()):
    signal.signal(number, lambda *_: None)

# CI asks whether a change is sound, and the same change gets the same answer; whoever works on it
# draws new examples with every run, and fewer of them.
settings.register_profile("quick", max_examples=20)
settings.load_profile("ci" if os.environ.get("ARMSIDE_CI") else "quick")
WHOLE = bool(os.environ.get("ARMSIDE_CI"))
"""In CI what is slow runs as it stands; else, with the same claims, a small form of it."""
TWIN_OF = "2001"
"""Individual whose twin is shared by the tests."""
OF_PICTURES = (
    "test_figures",
    "test_chapter",
    "test_gallery",
    "test_svg",
    "test_learn.py",
    "still_draws",
)
"""Parts of the names of the tests that look at what is drawn; elsewhere pictures are blank."""

SLOWEST = (
    "README.md",
    "test_claim_holds_for_one_seed_at_one_pose",
    "docs/twin.md",
    "test_300_command_lines",
    "docs/estimation.md",
    "test_packaging.py",
    "test_arm_side.py",
    "test_docs.py",
    "test_replay_shown.py",
)
"""Parts of the names of the tests and set-ups that take longest, the longest first."""


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Modules that all tests import are garbage at no time: their objects are not searched for it,
    neither while they are made nor with each later collection."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the slowest tests first: workers share the rest, and none ends alone with a long test."""

    def place(item: pytest.Item) -> int:
        return next((i for i, name in enumerate(SLOWEST) if name in item.nodeid), len(SLOWEST))

    items.sort(key=place)


@pytest.fixture(scope="session")
def made_once(tmp_path_factory):
    """A function that gives a folder of a name, made once for all workers of pytest-xdist, if any.

    It is called with the name and with what makes the folder: a function of its path.
    """
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own

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


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Draw the figures of tests about figures alone; in CI, all of them."""
    if module := sys.modules.get("matplotlib.figure"):
        looked_at = WHOLE or any(name in item.nodeid for name in OF_PICTURES)
        draw = vars(module).setdefault("drawn", module.Figure.savefig)
        module.Figure.savefig = draw if looked_at else blank


def blank(figure, file, **options) -> None:
    """Save a figure with nothing drawn on it."""
    empty = type(figure)(figsize=figure.get_size_inches(), dpi=figure.dpi)
    sys.modules["matplotlib.figure"].drawn(empty, file, **options)


@pytest.fixture(scope="session", autouse=True)
def searches_made_once(made_once):
    """Springs and twins of the same record are searched for once; in CI, each time."""
    with pytest.MonkeyPatch.context() as patch:
        if not WHOLE and "armside.sim" in sys.modules:
            from tests.searches import make_once

            make_once(made_once, patch)
        yield


@pytest.fixture(scope="session")
def commissioned(made_once):
    """Folder with the `twin` of `TWIN_OF`, made from one cut, and its summary as JSON."""

    def commission(folder):
        from armside.scripts import cli

        line = f"commission --individual {TWIN_OF} --cuts 1 --json --out {folder / 'twin'}"
        with redirect_stdout(StringIO()) as printed:
            assert cli.main(line.split()) == 0
        (folder / "printed.json").write_text(printed.getvalue())

    return made_once("commissioned", commission)


@pytest.fixture(scope="module")
def quick_identification():
    """Springs are identified from the best of the starts in a few steps; in CI, as they are.

    For tests of what is done with springs. Tests of the identification itself do without.
    """
    few = {"_FIRST_STEPS": 3, "_STEPS": 5, "_KEPT": 1}
    with pytest.MonkeyPatch.context() as patch:
        if not WHOLE:
            for name, value in few.items():
                patch.setattr(f"armside.ilc.estimation.prediction_error.{name}", value)
        yield


@pytest.fixture
def one_step_commissioning(monkeypatch):
    """A twin is commissioned in one step of its identification; in CI, in all of them.

    For tests of what goes into a twin, not of how good it is.
    """
    from armside.sim.twin import commission
    from armside.sim.twin.identification import Identification, identify

    def one_step(design, cuts, _cfg, progress, *, sensor):
        cfg = Identification(steps=1, linearised=(0,))
        return identify(design, cuts, cfg, progress, sensor=sensor)

    if not WHOLE:
        monkeypatch.setattr(commission, "identify", one_step)


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
    return importlib.import_module("tests.sim.gears.synthetic")


@pytest.fixture(scope="session")
def small_runs(made_once):
    """Folder with what the commands of `results_listed.SMALL` leave, a folder each."""
    from tests.results_listed import make_small

    return made_once("small-runs", make_small)

"""Commands load, and a default run works, where no extra is installed."""

import os
import subprocess
import sys

import pytest

from armside.scripts.cli import COMMANDS

EXTRAS = (
    *("shapely", "ezdxf", "svgelements", "cssselect2", "optuna", "cmaes", "control", "h5py"),
    *("mcap", "psycopg", "ray", "stable_baselines3", "google", "pinocchio", "rosbags"),
    *("roboticstoolbox", "hypothesis"),
)
BARE = f"""
import sys

class Nothing:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {EXTRAS}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Nothing())
"""

MAIN = "from armside.scripts.cli import main\nsys.exit(main(sys.argv[1:]))"
QUICK = """
from armside.ilc.estimation import prediction_error
prediction_error._FIRST_STEPS, prediction_error._STEPS, prediction_error._KEPT = 3, 5, 1
"""
"""Springs are identified in a few steps; in CI, as they are."""


def run(code: str, *words: str, cwd=None) -> str:
    done = subprocess.run(
        [sys.executable, "-c", BARE + code, *words], capture_output=True, text=True, cwd=cwd
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_command_shows_its_help_without_extras():
    shown = f"assert not any(main([name, '--help']) for name in {list(COMMANDS)})"
    run(f"from armside.scripts.cli import main\n{shown}")


@pytest.mark.parametrize(
    "words",
    [
        ("laser", "--iterations", "0"),
        ("laser", "--iterations", "0", "--measure", "estimate"),
        ("imu", "--motion", "rest", "--off", "3", "--on", "3"),
        ("learn", "--iterations", "1", "--samples", "50"),
        ("robot", "check"),
    ],
    ids=" ".join,
)
def test_a_run_works_without_extras(words, tmp_path):
    quick = "" if os.environ.get("ARMSIDE_CI") else QUICK
    out = () if words[0] == "robot" else ("--out", "run")
    assert run(quick + MAIN, *words, *out, cwd=tmp_path)

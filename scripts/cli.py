"""The command `armside <experiment> [--options]`.

Exit status: 0 done; 2 bad input, with one line on stderr and nothing written; 1 anything that
failed while running; 130 interrupted. Only the experiment that runs is imported.
"""

import os
import sys
import traceback
from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError, Parameter
from cyclopts.exceptions import UnknownCommandError, UnusedCliTokensError

from .shell.errors import InputError, RunFailed, one_line
from .shell.options import read_value
from .shell.registry import unknown

COMMANDS = {
    "laser": (
        "armside.scripts.commands.laser:laser",
        "Cut a shape with the virtual robot and learn to cut it.",
    ),
    "imu": ("armside.scripts.commands.imu:imu", "Predict what an IMU on the moving tool measures."),
    "identify": (
        "armside.scripts.commands.identify:identify",
        "Find the arm's springs from one cut and an IMU.",
    ),
    "compare": (
        "armside.scripts.commands.compare:compare",
        "Motor side, estimate, tracker and oracle, compared.",
    ),
    "replay": (
        "armside.scripts.commands.replay:replay",
        "Watch runs: viewer, browser, picture or film.",
    ),
    "view": (
        "armside.scripts.commands.view:view",
        "Move a robot by sliders in MuJoCo's own viewer.",
    ),
    "convert": (
        "armside.scripts.commands.convert:convert",
        "Write a run's signals as CSV, MATLAB, HDF5 or MCAP.",
    ),
    "measure": (
        "armside.scripts.commands.measure:measure",
        "Measure recorded data, a run's or your own.",
    ),
    "gallery": ("armside.scripts.commands.gallery:gallery", "Make the pictures of the docs again."),
    "two-mass": (
        "armside.scripts.commands.two_mass:two_mass",
        "Regenerate chapter 8: a flexible joint learns.",
    ),
    "design": (
        "armside.scripts.commands.design:design",
        "Propose gain, shift and cutoff for a model.",
    ),
    "tune": (
        "armside.scripts.commands.tune:tune",
        "Search the design of the learning law with Optuna.",
    ),
    "train": (
        "armside.scripts.commands.train:train",
        "Learn a policy that chooses designs (extra [learn]).",
    ),
    "sweep": (
        "armside.scripts.commands.sweep:sweep",
        "Run the laser experiment over a grid of its options.",
    ),
    "model": (
        "armside.scripts.commands.model:model",
        "Describe a robot: D-H table, reach, singularities.",
    ),
    "export": (
        "armside.scripts.commands.export:export",
        "Write a robot's equations as code, or the robot as URDF.",
    ),
    "bench": (
        "armside.scripts.commands.bench:bench",
        "Time this machine, beside other libraries if installed.",
    ),
    "calibrate": (
        "armside.scripts.commands.calibrate:calibrate",
        "Choose the large robot's unknown numbers again.",
    ),
    "verify": (
        "armside.scripts.commands.verify:verify",
        "Check a claim over many seeds and write its table.",
    ),
    "reproduce": (
        "armside.scripts.commands.reproduce:reproduce",
        "Make the figures of the thesis again, with verdicts.",
    ),
}
"""Name: (module:function, one line of help). A new experiment is one line here."""

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def make_app(chosen: str = "") -> App:
    """The parser of all commands. The chosen one is imported and shows its own docstring."""
    app = App(
        name="armside",
        help="Iterative learning control of industrial robots, seen from the arm side.",
        version=lambda: f"armside {version('armside')}",
        default_parameter=Parameter(converter=read_value, negative=""),
        print_error=False,
        exit_on_error=False,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
    )
    for name, (path, help_line) in COMMANDS.items():
        app.command(path, name=name, help=None if name == chosen else help_line)
    return app


def main(tokens: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    tokens = list(sys.argv[1:] if tokens is None else tokens)
    try:
        status = _run(tokens)
        sys.stdout.flush()
        return status
    except BrokenPipeError:  # the reader of our output left; nobody is there to be told
        _drop_unwritten_output()
        return FAILED
    except KeyboardInterrupt as stop:
        return _complain(str(stop) or "interrupted, nothing was kept", INTERRUPTED)
    except Exception as error:
        if "--debug" in tokens:
            traceback.print_exc()
        if isinstance(error, InputError):
            return _complain(one_line(error), BAD_INPUT)
        return _complain(_failure(error), FAILED)


def _run(tokens: list[str]) -> int:
    """Parse, then run: whatever parsing raises is bad input."""
    try:
        command, bound, _ = make_app(chosen=tokens[0] if tokens else "").parse_args(tokens)
    except UnknownCommandError:
        raise unknown("experiment", tokens[0], COMMANDS) from None
    except UnusedCliTokensError as error:
        words = " ".join(error.unused_tokens or ())
        raise InputError(f"Unexpected {words!r}; options are written --name value") from None
    except (CycloptsError, ValueError) as error:
        raise InputError(one_line(error)) from error
    command(*bound.args, **bound.kwargs)
    return DONE


def _failure(error: Exception) -> str:
    if isinstance(error, (RunFailed, OSError)):
        return one_line(error)
    return f"failed with {type(error).__name__}: {one_line(error)} (--debug shows where)"


def _complain(message: str, status: int) -> int:
    _drop_unwritten_output()
    print(f"armside: {message}", file=sys.stderr)
    return status


def _drop_unwritten_output() -> None:
    """Forget what stdout does not take, or Python would fail on it once more at its end."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())

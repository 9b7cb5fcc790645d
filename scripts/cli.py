"""The command `armside <experiment> [--options]`.

Exit status: 0 done; 2 bad input, with one line on stderr and nothing written; 1 anything that
failed while running; 130 interrupted. Only the command that runs is imported.
"""

import os
import re
import sys
import traceback
from collections.abc import Callable, Sequence
from importlib.metadata import version
from inspect import getdoc

from cyclopts import App, CycloptsError, Parameter
from cyclopts.exceptions import UnknownCommandError, UnusedCliTokensError

from .shell.errors import InputError, RunFailed, one_line
from .shell.options import read_value
from .shell.registry import unknown

COMMANDS = {
    "laser": "Cut a shape with the virtual robot and learn to cut it.",
    "imu": "Predict what an IMU on the moving tool measures.",
    "identify": "Find the arm's springs from one cut and an IMU.",
    "compare": "Learn from motors, estimate, tracker and ground truth.",
    "replay": "Watch runs: viewer, browser, picture or film.",
    "view": "Move a robot by sliders in MuJoCo's own viewer.",
    "convert": "Write a run's signals as CSV, MATLAB, HDF5 or MCAP.",
    "measure": "Measure recorded data, a run's or your own.",
    "gallery": "Make the pictures of the docs again.",
    "two-mass": "Regenerate chapter 8: a flexible joint learns.",
    "design": "Propose gain, shift and cutoff for a model.",
    "tune": "Search the design of the learning law with Optuna.",
    "train": "Learn a policy that chooses designs (extra [learn]).",
    "sweep": "Run the laser experiment over a grid of its options.",
    "model": "Describe a robot: D-H table, reach, singularities.",
    "export": "Write a robot's equations as code, or the robot as URDF.",
    "bench": "Time this machine, beside other libraries if installed.",
    "calibrate-arm": "Calibrate a real arm from measured poses.",
    "calibrate": "Choose the large robot's unknown numbers again.",
    "verify": "Check a claim over many seeds and write its table.",
    "reproduce": "Make the figures of the thesis again, with verdicts.",
}
"""Name: one line of help. A new command is one line here and two in `load`."""


def load(name: str) -> Callable[..., None]:
    """The function of a command. Only its module is imported, when the command is chosen."""
    match name:
        case "laser":
            from .commands.laser import laser as command
        case "imu":
            from .commands.imu import imu as command
        case "identify":
            from .commands.identify import identify as command
        case "compare":
            from .commands.compare import compare as command
        case "replay":
            from .commands.replay import replay as command
        case "view":
            from .commands.view import view as command
        case "convert":
            from .commands.convert import convert as command
        case "measure":
            from .commands.measure import measure as command
        case "gallery":
            from .commands.gallery import gallery as command
        case "two-mass":
            from .commands.two_mass import two_mass as command
        case "design":
            from .commands.design import design as command
        case "tune":
            from .commands.tune import tune as command
        case "train":
            from .commands.train import train as command
        case "sweep":
            from .commands.sweep import sweep as command
        case "model":
            from .commands.model import model as command
        case "export":
            from .commands.export import export as command
        case "bench":
            from .commands.bench import bench as command
        case "calibrate-arm":
            from .commands.calibrate_arm import calibrate_arm as command
        case "calibrate":
            from .commands.calibrate import calibrate as command
        case "verify":
            from .commands.verify import verify as command
        case "reproduce":
            from .commands.reproduce import reproduce as command
        case _:
            raise unknown("experiment", name, COMMANDS)
    return command


FOR_PROGRAMMERS = re.compile(r"(Raises|Returns|Yields)\b|(Args|Arguments|Parameters|Attributes):")
"""Begin of a paragraph of a docstring that help does not show."""

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def make_app(chosen: str = "") -> App:
    """The parser of all commands, of which only the chosen one is imported and knows its options.

    Its help is its docstring without the paragraphs for programmers.
    """
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
    for name, line in COMMANDS.items():
        if name == chosen:
            command = load(name)
            paragraphs = (getdoc(command) or line).split("\n\n")
            shown = "\n\n".join(text for text in paragraphs if not FOR_PROGRAMMERS.match(text))
            app.command(command, name=name, help=shown)
        else:
            app.command(App(name=name, help=line))
    return app


def main(tokens: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    tokens = list(sys.argv[1:] if tokens is None else tokens)
    try:
        _run(tokens)
        sys.stdout.flush()
        return DONE
    except BrokenPipeError:  # the reader of our output left: nobody reads a message
        _drop_unwritten_output()
        return FAILED
    except KeyboardInterrupt as stop:
        return _complain(str(stop) or "interrupted, nothing was kept", INTERRUPTED)
    except Exception as error:
        if "--debug" in tokens:
            traceback.print_exc()
        status, message = BAD_INPUT if isinstance(error, InputError) else FAILED, one_line(error)
        if not isinstance(error, (InputError, RunFailed, OSError)):
            message = f"failed with {type(error).__name__}: {message} (--debug shows where)"
        return _complain(message, status)


def _run(tokens: list[str]) -> None:
    """Parse, then run: whatever parsing raises is bad input."""
    app = make_app(chosen=tokens[0] if tokens else "")
    try:
        command, bound, _ = app.parse_args(tokens)
    except UnknownCommandError:
        raise unknown("experiment", tokens[0], COMMANDS) from None
    except UnusedCliTokensError as error:
        words = " ".join(error.unused_tokens or ())
        raise InputError(f"Unexpected {words!r}; options are written --name value") from None
    except (CycloptsError, ValueError) as error:
        raise InputError(one_line(error)) from error
    command(*bound.args, **bound.kwargs)


def _complain(message: str, status: int) -> int:
    _drop_unwritten_output()
    print(f"armside: {message}", file=sys.stderr)
    return status


def _drop_unwritten_output() -> None:
    """Drop output that stdout does not take, or Python would fail on it once more at its end."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())

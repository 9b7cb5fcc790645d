"""The command `armside <experiment> [--options]`.

Exit status: 0 done; 2 bad input, with one line on stderr and nothing written; 1 anything that
failed while running; 130 interrupted, or 128 and the number of another signal. Only the command
that runs is imported, and nothing before Ctrl-C can be answered in one line.
"""

import sys
from collections.abc import Callable, Sequence
from importlib import import_module

COMMANDS = {
    "laser": ("Cut", "Cut a shape with the virtual robot and learn to cut it."),
    "cut": ("Cut", "Cut a whole part from its drawing and learn to cut it."),
    "commission": ("Cut", "Make a robot's digital twin from a few cuts."),
    "compare": ("Cut", "Learn from motors, estimate, tracker and ground truth."),
    "sweep": ("Cut", "Run the laser experiment over a grid of its options."),
    "learn": ("Learn", "Compare learning laws on any plant, your own too."),
    "identify-plant": ("Learn", "Identify a model from your record or an experiment."),
    "design": ("Learn", "Propose gain, shift and cutoff for a model."),
    "tune": ("Learn", "Search the design of the learning law with Optuna."),
    "train": ("Learn", "Learn a policy that chooses designs (extra [learn])."),
    "contest": ("Learn", "Judge and rank entries of learning control on sealed tasks."),
    "robot": ("Robot", "Check, show or build a robot, or start its robot file."),
    "export": ("Robot", "Write a robot's equations, a robot, or what a run learned."),
    "measure": ("Real arm", "Measure recorded data, a run's or your own."),
    "identify": ("Real arm", "Find the arm's springs from one cut and an IMU."),
    "imu": ("Real arm", "Predict what an IMU on the moving tool measures."),
    "calibrate-arm": ("Real arm", "Calibrate a real arm from measured poses."),
    "gears": ("Real arm", "Find the transmission error of a real arm's gears."),
    "path-logs": ("Real arm", "Compare a real robot's motor logs with the virtual robot."),
    "convert": ("Real arm", "Write runs, recordings and logs as other files."),
    "program": ("Real arm", "Describe a robot's program: RAPID, KRL or URScript."),
    "scan": ("Real arm", "See what was cut by a flatbed scan of the sheet."),
    "serve": ("Real arm", "Put the virtual robot behind a controller's protocol."),
    "replay": ("Look", "Watch runs: viewer, browser, picture or film."),
    "reproduce": ("Reproduce", "Make the figures of the thesis again, with verdicts."),
}
"""Name: group in `armside --help`, and line of help. A command is the function of this name in the
file of this name in `commands`."""


def load(name: str) -> Callable[..., None]:
    """The function of a command. Only its module is imported, when the command is chosen."""
    if name not in COMMANDS:
        from .shell.errors import unknown

        raise unknown("experiment", name, COMMANDS)
    name = name.replace("-", "_")
    return getattr(import_module(f"armside.scripts.commands.{name}"), name)


def main(tokens: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status.

    tokens: the command line; None for that of this process, whose streams, warnings and signals
    then belong to the command.
    """
    try:
        from .shell import runner

        if tokens is not None:
            return runner.run(list(tokens), COMMANDS, load)
        runner.begin(debug="--debug" in sys.argv)
        return runner.run(sys.argv[1:], COMMANDS, load)
    except KeyboardInterrupt:  # while Python still imports
        print("armside: interrupted, nothing was kept", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())

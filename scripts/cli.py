"""The command `armside <experiment> [--options]`.

Exit status: 0 done; 2 bad input, with one line on stderr and nothing written; 1 anything that
failed while running; 130 interrupted, or 128 and the number of another signal. Only the command
that runs is imported, and nothing before Ctrl-C can be answered in one line.
"""

import sys
from collections.abc import Callable, Sequence

COMMANDS = {
    "laser": "Cut a shape with the virtual robot and learn to cut it.",
    "cut": "Cut a whole part from its drawing and learn to cut it.",
    "imu": "Predict what an IMU on the moving tool measures.",
    "identify": "Find the arm's springs from one cut and an IMU.",
    "commission": "Make a robot's digital twin from a few cuts.",
    "compare": "Learn from motors, estimate, tracker and ground truth.",
    "replay": "Watch runs: viewer, browser, picture or film.",
    "view": "Move a robot by sliders in MuJoCo's own viewer.",
    "convert": "Write runs, recordings and logs as other files.",
    "export-correction": "Write the learned correction for a controller.",
    "measure": "Measure recorded data, a run's or your own.",
    "two-mass": "Regenerate chapter 8: a flexible joint learns.",
    "learn": "Compare learning laws on any plant, your own too.",
    "serve": "Put the virtual robot behind a controller's protocol.",
    "identify-plant": "Identify a model from your record or an experiment.",
    "design": "Propose gain, shift and cutoff for a model.",
    "tune": "Search the design of the learning law with Optuna.",
    "train": "Learn a policy that chooses designs (extra [learn]).",
    "sweep": "Run the laser experiment over a grid of its options.",
    "model": "Describe a robot: D-H table, reach, singularities.",
    "robot": "Check, show or build a robot, or start its robot file.",
    "export": "Write a robot's equations as code, or it as URDF or MJCF.",
    "calibrate-arm": "Calibrate a real arm from measured poses.",
    "gears": "Find the transmission error of a real arm's gears.",
    "path-logs": "Compare a real robot's motor logs with the virtual robot.",
    "reproduce": "Make the figures of the thesis again, with verdicts.",
}
"""Name: one line of help. A new command is one line here and two in `load`."""


def load(name: str) -> Callable[..., None]:
    """The function of a command. Only its module is imported, when the command is chosen."""
    match name:
        case "laser":
            from .commands.laser import laser as command
        case "cut":
            from .shell.extras import needs

            with needs("parts", "armside cut", "shapely, ezdxf and svgelements"):
                from .commands.cut import cut as command
        case "imu":
            from .commands.imu import imu as command
        case "identify":
            from .commands.identify import identify as command
        case "commission":
            from .commands.commission import commission as command
        case "compare":
            from .commands.compare import compare as command
        case "replay":
            from .commands.replay import replay as command
        case "view":
            from .commands.view import view as command
        case "convert":
            from .commands.convert import convert as command
        case "export-correction":
            from .commands.export_correction import export_correction as command
        case "measure":
            from .commands.measure import measure as command
        case "two-mass":
            from .commands.two_mass import two_mass as command
        case "learn":
            from .commands.learn import learn as command
        case "serve":
            from .commands.serve import serve as command
        case "identify-plant":
            from .commands.identify_plant import identify_plant as command
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
        case "robot":
            from .commands.robot import robot as command
        case "export":
            from .commands.export import export as command
        case "calibrate-arm":
            from .commands.calibrate_arm import calibrate_arm as command
        case "path-logs":
            from .commands.path_logs import path_logs as command
        case "gears":
            from .commands.gears import gears as command
        case "reproduce":
            from .commands.reproduce import reproduce as command
        case _:
            from .shell.registry import unknown

            raise unknown("experiment", name, COMMANDS)
    return command


def main(tokens: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status.

    tokens: the command line; None for that of this process, whose streams, warnings and signals
    then belong to the command.
    """
    try:
        from .shell import process
        from .shell.runner import run

        if tokens is not None:
            return run(list(tokens), COMMANDS, load)
        process.begin(debug="--debug" in sys.argv)
        return run(sys.argv[1:], COMMANDS, load)
    except KeyboardInterrupt:  # while Python still imports
        print("armside: interrupted, nothing was kept", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())

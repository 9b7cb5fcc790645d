"""Chapter 5 of the thesis, section by section: an IMU on the virtual IRB1400 and its kinematics."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.sim.evaluation.check import Check, Table
from armside.sim.imu import ImuExperiment
from armside.sim.imu.phases import FAST_CIRCLE, RECTANGLE, SLOW_CIRCLE, WINDOW
from armside.sim.robot.flexibility import Flexibility
from armside.sim.robot.kinematics_check import site_poses

from ..figures import imu as figures
from ..jobs.store import Result
from . import imu_checks as checks
from .imu_checks import differences
from .imu_job import ImuJob, RestJob
from .report import Asked, Entry, Part, Read, Section

Drawn = tuple[str, Sequence[str], Sequence[Check], Sequence[Table]]
"""Caption, names of figures, checks and tables of a section."""
Draw = Callable[..., Drawn]
"""Called with the folder for figures and the results of the section's jobs."""

BASE = ImuExperiment()
SEQUENTIAL = replace(BASE, motion="sequential")
UNAIDED = replace(SEQUENTIAL, torque_feedforward=False)
GEARS, RIGID = (replace(BASE, flexibility=f) for f in (Flexibility.GEARS, Flexibility.RIGID))
INDIVIDUALS = 20  # IMUs whose clocks are synchronised
PROCESSED = {"default": "", "as in the thesis": "as_thesis_", "mapped, then filtered": "best_"}
"""Beginnings of the names of results, by the processing."""
REST = RestJob()
MOVING = ImuJob(individuals=INDIVIDUALS)  # the simultaneous motion, which most sections share
MOTIONS = {
    "motors 1 to 3 in sequence": ImuJob(experiment=SEQUENTIAL, program=0),
    "motors 4 to 6 in sequence": ImuJob(experiment=SEQUENTIAL, program=1),
    "all motors at once": MOVING,
    "all motors at once, only gears elastic": ImuJob(experiment=GEARS),
    checks.RIGID: ImuJob(experiment=RIGID),
}
ONE_BY_ONE = [ImuJob(experiment=e, program=i) for e in (SEQUENTIAL, UNAIDED) for i in (0, 1)]
ENTRIES: list[Entry] = []
"""Sections in the order of the report."""
PARTS = {"slow circle": SLOW_CIRCLE, "fast circle": FAST_CIRCLE, "rectangle": RECTANGLE}


def _section(
    id: str, title: str, *jobs: ImuJob | RestJob, also: tuple[str, ...]
) -> Callable[[Draw], Draw]:
    """Decorator: adds a section, from a function that draws the jobs' results."""

    def added(draw: Draw) -> Draw:
        def make(asked: Asked) -> Part:
            seeded = [replace(job, seed=asked.seed) for job in jobs]

            def section(read: Read, folder: Path) -> Section:
                return Section(id, title, *draw(folder, *map(read, seeded)))

            return Part(seeded, section)

        ENTRIES.append(Entry(id, make, also))
        return draw

    return added


def _grid(title: str, rows: Iterable[tuple[str, Array]], columns: Sequence[str] = "xyz") -> Table:
    """A table of named vectors."""
    return Table(title, ["", *columns], [[name, *map(float, values)] for name, values in rows])


def _by_processing(title: str, result: Result, name: str) -> Table:
    """A vector of the results, by the processing."""
    rows = ((label, result[f"{prefix}{name}"]) for label, prefix in PROCESSED.items())
    return replace(_grid(title, rows), columns=["processed", *"xyz"])


@_section("5.2", "Fig. 5.2: acceleration at rest, motors off and on", REST, also=("E02",))
def rest(folder: Path, result: Result) -> Drawn:
    off = REST.experiment.off
    figures.rest(folder / "5.2.png", result["time"], result["acceleration"], off)
    spectra = (result[name] for name in ("frequency", "off_spectrum", "on_spectrum"))
    figures.spectrum(folder / "5.2-spectrum.png", *spectra)
    rows = {"motors off, RMS": "off_rms", "motors on, RMS": "on_rms"}
    rows["motors on, exceeded by 0.3 %"] = "on_level"
    return (
        "The robot stands in its zero pose. With the brakes on, only the sensor adds "
        "noise; with the motors on, noise of torques and encoders makes the arm vibrate at its "
        "own frequencies. The means are those of a sensor mounted with a small tilt. In x it "
        "vibrates a third as much as in z; the thesis draws all three on axes of the same "
        "width. It names a peak at 27 Hz, but not the line near 15 Hz that x and y have here.",
        ["5.2.png", "5.2-spectrum.png"],
        checks.noise(result),
        [_grid("Acceleration about its mean [m/s²]", ((k, result[v]) for k, v in rows.items()))],
    )


@_section("5.3", "(5.1), Fig. 5.3, Table 5.1: the IMU as two constant links", also=("E01",))
def mounting(folder: Path) -> Drawn:
    cell, zero = BASE.cell, np.zeros((1, 6))
    T_base_tool, T_base_imu = (
        kinematics.compile(robot).pose(zero)[0] for robot in (cell.robot, cell.with_imu)
    )
    site = site_poses(RIGID.model(), zero, "imu")[0][0, :3, 3]
    positions = {
        "from TCP0, by the links": 1e3 * (T_base_imu - T_base_tool)[:3, 3],
        "from the base, by the links": 1e3 * T_base_imu[:3, 3],
        "from the base, virtual robot": 1e3 * site,
    }
    return (
        "Two links without a joint lead from the tool's frame to the IMU's, because "
        "one standard D-H link cannot. In the zero pose the IMU's axes are those of the base.",
        [],
        checks.mounted(T_base_tool, T_base_imu, site),
        [_grid("IMU in the zero pose [mm]", positions.items())],
    )


@_section("synchronisation", "5.3.1: synchronisation of the clocks", MOVING, also=("E04",))
def synchronisation(folder: Path, result: Result) -> Drawn:
    early = result["time"] < result["since"]
    names = ("best_angular_velocity_measured", "best_angular_velocity_predicted")
    measured, predicted = (result[name][early][:, 2] for name in names)
    offset, errors, file = result["clock_offset"], result["clock_errors"], "synchronisation.png"
    time = result["time"][early]
    figures.clocks(folder / file, time, measured, predicted, float(offset), errors)
    return (
        "Motor 1 swings before the experiment. The thesis reads from the noisy signal "
        "by hand when that began; here the offset is that with which gyro and motor angles "
        "agree best, minus the known delay of the gyro's own filter. The same run is "
        f"then measured by {INDIVIDUALS} other IMUs whose clocks are up to 0.4 s off.",
        [file],
        checks.clocks(result),
        [],
    )


@_section("5.4", "Fig. 5.4: sequential motion, two experiments", *ONE_BY_ONE, also=("E05",))
def sequential(folder: Path, arm: Result, wrist: Result, *without: Result) -> Drawn:
    files = ["5.4-arm.png", "5.4-wrist.png"]
    for file, result in zip(files, (arm, wrist), strict=True):
        figures.motor_angles(folder / file, result["log_time"], result["motor_angle"])
    pairs = ((arm, wrist), without)
    aided, unaided = (1e4 * np.fmax(*(run["idle_peaks"] for run in pair)) for pair in pairs)
    title = "Largest peak of each motor while others move [1e-4 rad]"
    peaks = {"with feedforward": aided, "without": unaided}
    return (
        "One motor at a time, 1 to 3 first and 4 to 6 in a second experiment. Motors "
        "that should stand still move a little in the thesis's log. Here they move less "
        "with a servo that anticipates torques, and by about as much without: "
        "a motor creeps on from where friction stopped it, mostly in the wrist.",
        files,
        checks.one_at_a_time(arm, wrist, aided, unaided),
        [_grid(title, peaks.items(), [f"motor {i}" for i in range(1, 7)])],
    )


@_section("5.5", "Figs. 5.5 and 5.6: simultaneous motion", MOVING, also=("E03", "E06", "5.6"))
def simultaneous(folder: Path, result: Result) -> Drawn:
    angle = result["motor_angle"]
    figures.motor_angles(folder / "5.5.png", result["log_time"], angle)
    figures.path(folder / "5.6.png", result["imu_position"])
    return (
        "Motor 1 swings to synchronise; then all motors move to a starting point, two circles "
        "follow at 0.5 and 1.0 m/s, a rectangle as fast as the joints allow, and the return. The "
        "thesis prints no coordinates: this path was chosen to come near the axes of its figures. "
        f"Motors 4 and 6 go to {np.abs(angle).max():.2f} rad, where those end at 1.",
        ["5.5.png", "5.6.png"],
        checks.all_at_once(result),
        [],
    )


@_section("5.7", "Fig. 5.7: position of the tool", *MOTIONS.values(), also=("E07",))
def position(folder: Path, *runs: Result) -> Drawn:
    results = dict(zip(MOTIONS, runs, strict=True))
    files = ["5.7-arm.png", "5.7-wrist.png", "5.7-simultaneous.png"]
    for file, run in zip(files, runs, strict=False):
        figures.position(folder / file, run["log_time"], run["tool"], run["tool_predicted"])
    peers = differences()
    apart = (1e3 * np.abs(run["tool"] - run["tool_predicted"]).max(axis=0) for run in runs)
    return (
        "True position of the tool, and its position by the D-H equations from the "
        "logged motor angles: motors 1 to 3 and 4 to 6 in sequence, as in the thesis, and all "
        "at once. The thesis compares with the position that the robot system reports; here it "
        "is the ground truth, which includes the elastic deflection of gears and structure, "
        "under gravity even at rest. On the angles of (5.13) the thesis compares toolboxes, and "
        "finds differences in the magnitude of 1e-15.",
        files,
        [*checks.distances(results), checks.toolbox_poses(peers)],
        [
            _grid("Tool to D-H, largest in each direction [mm]", zip(MOTIONS, apart, strict=True)),
            Table(
                "Poses by other toolboxes on the angles of (5.13), largest difference from ours",
                ["", "m, or entry of the rotation"],
                [[name, "not installed" if e is None else e] for name, e in peers.items()],
            ),
        ],
    )


@_section("5.8", "Fig. 5.8: angular velocity of the IMU", MOVING, also=("E08",))
def angular_velocity(folder: Path, result: Result) -> Drawn:
    _draw_vector(folder / "5.8.png", result, "angular_velocity")
    title = "Angular velocity, measured minus predicted, RMS [rad/s]"
    return (
        "The gyro against the D-H equations with differentiated motor angles, "
        "both low-pass filtered at 5 Hz, after the synchronisation. The difference is "
        "mostly method: the thesis filters joint rates before a map that is not linear, which "
        "shows where motors 4 and 6 swing in opposition. With central differences and the "
        "filter after the map, little error remains.",
        ["5.8.png"],
        checks.rates(result),
        [_by_processing(title, result, "angular_velocity_rms")],
    )


@_section("5.9", "Fig. 5.9: linear acceleration of the IMU", MOVING, also=("E09",))
def acceleration(folder: Path, result: Result) -> Drawn:
    _draw_vector(folder / "5.9.png", result, "acceleration")
    title = "Acceleration, measured minus predicted, RMS [m/s²]"
    return (
        "The accelerometer without gravity and offsets against twice differentiated "
        "motor angles, both filtered at 5 Hz, after the synchronisation.",
        ["5.9.png"],
        checks.accelerations(result),
        [_by_processing(title, result, "acceleration_rms")],
    )


def _draw_vector(file: Path, result: Result, name: str) -> None:
    """A vector, measured and predicted, after the synchronisation."""
    late, keys = result["time"] >= result["since"], (f"{name}_measured", f"{name}_predicted")
    figures.vector(file, *(result[key][late] for key in ("time", *keys)), quantity=name)


@_section(
    "5.10", "Fig. 5.10: RMS of the acceleration error along the motion", MOVING, also=("E10",)
)
def error_along(folder: Path, result: Result) -> Drawn:
    late = result["time"] >= result["since"]
    shown = {name: PROCESSED[name] for name in ("default", "as in the thesis")}
    curves = {f"processed: {k}": result[f"{v}window_rms"][late] for k, v in shown.items()}
    shaded: dict[str, tuple[float, float]] = {}
    for name, speed in PARTS.items():  # [m/s], programmed along the path of a part
        moves = result["move_speed"] == speed
        start, end = result["move_start"][moves].min(), result["move_end"][moves].max()
        shaded[name] = float(start), float(end)
    figures.acceleration_error(folder / "5.10.png", result["time"][late], curves, WINDOW, shaded)
    rows = [
        [name, what, *map(float, result[f"{prefix}acceleration_window_{key}"])]
        for name, prefix in PROCESSED.items()
        for what, key in (("[m/s²]", "max"), ("at [s]", "time"))
    ]
    table = Table(f"Largest RMS over {WINDOW:g} s", ["processed", "", *"xyz"], rows)
    return (
        f"RMS of the error of Fig. 5.9, over {WINDOW:g} s. The thesis has one delay "
        "for both sensors and subtracts gravity by the mean at rest; by default each sensor "
        "has its own delay, and gravity follows the orientation. That the error stays "
        "below 0.8 m/s² proves little: softer gears and clocks out of step raise it alike. "
        "The instants and axes of its largest values are stronger evidence.",
        ["5.10.png"],
        checks.windows(result),
        [table],
    )

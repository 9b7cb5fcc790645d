"""The opposite of what a check of `reproduce` states fails it: a fall of 5 % for a rise, and so on.

Each section is drawn, without its figures, from results for which its checks hold, and again with
the one change in the table. Where the thesis states a number, the opposite is another number.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest

from armside.ilc.models.system import System
from armside.kinematics.calibration.calibrate import Errors
from armside.scripts.figures import two_mass
from armside.scripts.thesis import chapter8, chapter_papers, chapter_real, imu_checks
from armside.scripts.thesis import chapter9 as nine
from armside.scripts.thesis.chapter9 import bands, sections
from armside.scripts.thesis.entries import chapters
from armside.scripts.thesis.report import Asked
from armside.sim.evaluation.check import Check

from .test_chapter9 import CORRECTION, thesis_like
from .test_papers import results as as_in_papers

Of = SimpleNamespace


# Chapter 9: results by job


Job = Any
Change = Callable[[Job, dict[str, Any]], None]


def asked(job: Job, pose="", speed=0.0, cutoff=0.0, delta=0, ten=False, own=False, helped=False):
    """Whether a job is the one that is meant: 40 mm/s, 10 Hz and a shift of 3, if not stated."""
    design, cut = job.design, job.cut
    return (
        pose in ("", cut.pose)
        and (not speed or np.isclose(1e3 * cut.speed, speed))
        and (not cutoff or design.cutoff == (cutoff,))
        and (not delta or design.delta == (delta,))
        and (not ten or job.iterations == 10)
        and (not own or len(design.gamma) == 6)
        and (not helped or cut.friction_feedforward is not None)
    )


def times(name: str, factor: Any, k: Any = 5, motor: Any = slice(None), **of: Any) -> Change:
    """A measure of some experiments times a factor, at an iteration and of a motor (from 0)."""

    def change(job: Job, result: dict[str, Any]) -> None:
        if asked(job, **of):
            values = np.array(result[name], dtype=float)
            values[(k, motor) if values.ndim == 2 else k] *= factor
            result[name] = values

    return change


def rms(pose: str, *values: float) -> Change:
    """RMS of the tool over that of k = 0."""

    def change(job: Job, result: dict[str, Any]) -> None:
        if job.cut.pose == pose:
            result["arm_rms"] = 3e-4 * np.array(values)

    return change


def answered(answer: np.ndarray) -> Change:
    """Motors that answer the correction of k = 5, almost all that is learned, like this."""

    def change(job: Job, result: dict[str, Any]) -> None:
        learned = 1.0 - 0.4 ** np.arange(len(result["arm_rms"]))  # as `test_chapter9.result`
        result["error"] = result["error"][0] - learned[:, None, None] * answer

    return change


def first_update(job: Job, result: dict[str, Any]) -> None:
    """An error that grows by 5 % in the first update, which the model says falls."""
    if len(result["error"]) > 1:
        result["error"] = result["error"].copy()
        result["error"][1] = 1.05 * result["error"][0]


def noisy(factor: float) -> Change:
    """Experiments that repeat worse."""

    def change(job: Job, result: dict[str, Any]) -> None:
        rng = np.random.default_rng(job.repetition + 50)
        size = factor * result["motor_inf"].min() / 200.0
        result["error"] = result["error"] + rng.uniform(-size, size, result["error"].shape)

    return change


def diverges(job: Job, result: dict[str, Any]) -> None:
    result["diverged"] = np.array(True)


def some(n: int, change: Change) -> Change:
    """Of a hundred individuals the first n only."""

    def changed(job: Job, result: dict[str, Any]) -> None:
        if job.cut.individual is not None and job.cut.individual < n:
            change(job, result)

    return changed


ONE = {"pose": "p1", "cutoff": 15.0}
FALLS = (1.0, 0.6, 0.59, 0.58, 0.575, 0.57)
QUICK = System(np.append(np.zeros(5), 0.9), np.array([1.0, -0.1]), 0.004)
LATE = System(np.append(np.zeros(9), 0.5083), np.array([1.0, -0.4884]), 0.004)

CHAPTER_9: dict[str, tuple[str, Change]] = {  # by id: section, change
    "a1": ("9.9", times("motor_inf", 1.05 / 0.03, motor=2, pose="p3")),  # a rise of 5 %
    "a2": ("9.9", times("motor_inf", 1.05 / 0.03)),
    "a3": ("9.9", times("motor_inf", 1.05 / 0.03, motor=1, pose="p2")),
    "a4": ("9.9", times("motor_inf", 1.05 / 0.03, motor=1, pose="p2")),
    "a5": ("9.7", times("motor_two", 0.7, k=10, ten=True)),  # a fall by 30 % more
    "a6": ("9.8", first_update),
    "b1": ("9.10", times("arm_rms", 1.05 / 0.4, pose="p1")),
    "b2": ("9.10", times("arm_maxdev", 1.05 / 0.4, pose="p1")),
    "b3": ("9.11", rms("p2", 1.0, 0.6, 0.63, 0.61, 0.59, 0.57)),  # rises once, ends 5 % lower
    "b4": ("9.11", rms("p2", *FALLS)),
    "b5": ("9.11", rms("p3", 1.0, 0.99, 0.98, 0.97, 0.96, 0.95)),
    "b6": ("9.11", times("arm_rms", 1.05 * 0.65 / 0.4, pose="p1")),
    "b7": ("9.11", times("arm_rms", 0.95 * 0.65 / 1.1, pose="p3")),
    "c1": ("9.16", times("arm_rms", 0.95 / 1.2, **ONE)),
    "c2": ("9.16", times("arm_maxdev", 0.95 / 1.32, **ONE)),
    "c3": ("9.17", times("ripple", 0.95 / 2.0, **ONE)),
    "c4": ("9.14", times("motor_inf", 1.05 / 0.95, motor=0, **ONE)),  # one motor of six
    "c5": ("9.14", times("motor_inf", 1.05 / 0.6, motor=2, **ONE)),
    "c6": ("9.15", times("motor_inf", 1.05 / 0.5, motor=3, cutoff=22.5)),
    "c7": ("9.14", times("motor_two", 1.05 / 0.8, **ONE)),
    "d1": ("9.13", times("arm_rms", 1.05 / 0.9, pose="p1", delta=6)),
    "d2": ("9.13", times("arm_rms", 1.05 / 0.9, pose="p2", delta=6)),
    "d3": ("9.12", times("motor_inf", 2.1, motor=4, delta=1)),
    "e1": ("9.8", answered(CORRECTION[::-1] - CORRECTION)),
    "e2": ("9.8", answered(1.05 * bands.THESIS_MODEL.simulate(CORRECTION))),
    "e3": ("9.8", answered(LATE.simulate(CORRECTION))),
    "e4": ("9.8", answered(QUICK.simulate(CORRECTION))),
    "f1": ("9.5", times("motor_inf", 1.05 / 0.9, k=0, motor=2, pose="p1")),
    "f2": ("9.5", times("motor_inf", 0.5, k=0, motor=3, pose="p1")),
    "f3": ("9.5", times("motor_inf", 0.5, k=0, motor=3, pose="p3")),
    "f4": ("9.5", times("motor_inf", 1.05 * 0.9 / 0.7, k=0, motor=3, pose="p2")),
    "f5": ("9.6", times("motor_inf", 0.95 * 0.4 / 1.1, k=0, motor=1, speed=80.0, pose="p2")),
    "f6": ("9.6", times("motor_inf", 1.05, k=0, motor=1, speed=100.0, pose="p2")),
    "g1": ("repeatability", noisy(0.5)),
    "F07a": ("F07", some(1, diverges)),
    "F07b": ("F07", some(51, times("arm_rms", 1.05 / 0.4, pose="p1"))),
    "F07c": ("F07", some(11, times("arm_rms", 0.95 * 0.65 / 1.1, pose="p3"))),
    "F07d": ("F07", some(51, times("arm_rms", 0.94 / 1.1, pose="p3"))),
    "F08a": ("F08", times("motor_inf", 1.05 / 0.3, own=True)),
    "F08b": ("F08", times("motor_inf", 1.05 / 0.3, motor=[0, 1, 2], own=True)),
    "F09a": ("F09", times("motor_inf", 1.05 / 0.6, k=0, helped=True)),
    "F09b": ("F09", times("motor_inf", 1.05 / 0.6, helped=True)),
}
MODELS: dict[str, tuple[System, float]] = {  # (9.12) and its gain: another model, or gain
    "e5": (bands.THESIS_MODEL, 2.1),
    "e6": (System(np.array([0.0, 0.5083]), np.array([1.0, -0.4884]), 0.004), 0.9),
    "e7": (LATE, 0.9),
}


def silent(patch: pytest.MonkeyPatch, *modules: ModuleType) -> None:
    """Functions of these modules draw nothing."""
    for module in modules:
        for name, value in vars(module).items():
            if callable(value) and getattr(value, "__module__", "") == module.__name__:
                patch.setattr(module, name, lambda *_, **__: None)


def section_9(id: str, change: Change | None = None) -> list[Check]:
    """Checks of a section of chapter 9."""

    def read(job: Job) -> dict[str, Any]:
        made = thesis_like(job)
        if len(job.design.gamma) == 6:
            made["motor_inf"] = made["motor_inf"] * np.where(np.arange(6) < 1, 1, 0.6)[:, None]
        if job.cut.friction_feedforward:
            made["motor_inf"] = 0.6 * made["motor_inf"]
        made["error"] = (
            made["error"] * np.where(np.arange(len(made["error"])) == 1, 0.5, 1)[:, None, None]
        )
        for each in (noisy(0.05), change):
            if each is not None:
                each(job, made)
        return made

    (entry,) = (entry for entry in nine.ENTRIES if entry.id == id)
    with pytest.MonkeyPatch.context() as patch:
        silent(patch, sections.figures)
        patch.setattr(sections, "circle_figure", lambda *_, **__: None)
        return list(entry.make(Asked()).draw(read, Path()).checks)


# Chapter 8: cells of the tables


def row(section: str, value: float, column: str, *beginning: Any) -> tuple[str, Any, float]:
    return section, (column, *beginning), value


AT, NORM, OVER = "frequency [Hz]", "2-norm [rad]", "overshoot [rad]"
LAST, EARLY, CUT = "k = 500", "k = 25", "largest cutoff [Hz]"
GAIN, BEST = "gamma, delta 5 (arm 15)", "best delta"
STATED, LESS = two_mass.AS_STATED, two_mass.ONE_LESS
GAMMA, IDEAL, WRONG = "gamma |Tu(0)|", "ideal model", "model error"
HELD_8: list[tuple[str, Any, float]] = [  # the thesis's numbers, or those of its equations
    row("8.3", 1.1978, AT, "notch of the motor, G_m"),
    row("8.3", -19.5, "magnitude [dB]", "notch of the motor, G_m"),
    row("8.3", 1.0983, AT, "peak of the arm, G_a"),
    row("8.3", 1.1305, AT, "zeros of G_m(s) = poles of G_a(s)"),
    row("8.4", 2.5, "value", "largest speed [rad/s]"),
    row("8.5", 5.0, "reference ends at [rad]", "motor"),
    row("8.5", 5.32128, "2-norm of the error [rad]", "motor"),
    row("8.5", 1.46962, "2-norm of the error [rad]", "arm"),
    row("8.5", 0.0413, OVER, "arm"),
    *(row("8.6", 0.1, "max |1-LTu| [dB]", delta) for delta in (0, 2, 4, 6)),
    *(row("8.6", f, CUT, delta) for delta, f in ((0, 11.0), (2, 22.0), (4, 38.0))),
    *(row("8.7", g, GAIN, side, f) for side, f, g in (
        ("motor", 0.5, 2.0), ("motor", 1.0, 1.9987), ("arm", 0.5, 9.7856), ("arm", 1.0, 5.4308),
    )),
    *(row("8.7", g, GAMMA, side, 0.5) for side, g in (("motor", 1.0), ("arm", 0.95))),
    row("8.7", 5, BEST, "motor", 17.0),
    row("8.7", 5, "best multiple of 5", "motor", 17.0),
    row("8.7", 15, BEST, "arm", 30.0),
    *(row("8.8", 5.32128, "k = 0", name) for name in ("17 Hz", STATED, LESS)),
    *(row("8.8", e, LAST, f) for f, e in (("1 Hz", 1.557), ("6 Hz", 0.548), ("17 Hz", 0.19854))),
    *(row("8.8", 0.006, "largest rise", f) for f in ("1 Hz", "6 Hz", "17 Hz")),
    *(row("8.8", 0.15, EARLY, name) for name in (STATED, LESS)),
    *(row("8.8", 80.0, LAST, name) for name in (STATED, LESS)),
    *(row("8.9", e, NORM, k) for k, e in ((1, 1.31447), (2, 0.6645), (5, 0.27668))),
    *(row("8.10", e, NORM, k) for k, e in ((0, 1.46962), (1, 0.52199), (5, 0.13409))),
    row("8.11", 1.0, LAST, "motor", IDEAL), row("8.11", 1.0, LAST, "motor", WRONG),
    row("8.11", 1.46962, "k = 0", "arm", IDEAL), row("8.11", 0.12913, LAST, "arm", IDEAL),
    row("8.11", 2.04878, "k = 0", "arm", WRONG), row("8.11", 1.0285, LAST, "arm", WRONG),
    row("8.12", 0.1555, OVER, 0), row("8.12", 0.1456, OVER, 500),
]  # fmt: skip
CHAPTER_8: dict[str, tuple[str, Any, float]] = {
    "S01.1": row("8.3", 1.05 * 1.1978, AT, "notch of the motor, G_m"),
    "S01.2": row("8.3", -18.5, "magnitude [dB]", "notch of the motor, G_m"),
    "S01.3": row("8.3", 1.05 * 1.0983, AT, "peak of the arm, G_a"),
    "S01.4": row("8.3", 1.05 * 1.1305, AT, "zeros of G_m(s) = poles of G_a(s)"),
    "S02.1": row("8.4", 1.9, "value", "largest speed [rad/s]"),
    "S02.2": row("8.5", 4.9, "reference ends at [rad]", "motor"),
    "S02.3": row("8.5", 1.05 * 5.32128, "2-norm of the error [rad]", "motor"),
    "S02.4": row("8.5", 1.05 * 1.46962, "2-norm of the error [rad]", "arm"),
    "S02.5": row("8.5", 0.0, OVER, "arm"),
    "S03.1": row("8.6", -0.01, "max |1-LTu| [dB]", 4),  # a shift that needs no Q
    "S03.2": row("8.6", 0.1, "gain"),  # a gain that needs no Q
    "S03.3": row("8.6", 0.95 * 11.0, CUT, 0),
    "S03.4": row("8.6", 0.95 * 22.0, CUT, 2),
    "S03.5": row("8.6", 0.95 * 38.0, CUT, 4),
    "S04.1": row("8.7", 1.9, GAIN, "motor", 0.5),
    "S04.2": row("8.7", 2.0, GAIN, "motor", 1.0),
    "S04.3": row("8.7", 9.3, GAIN, "arm", 0.5),
    "S04.4": row("8.7", 9.8, GAIN, "arm", 1.0),
    "S04.5": row("8.7", 1.05, GAMMA, "arm", 0.5),
    "S04.6": row("8.7", 6, BEST, "motor", 17.0),
    "S04.7": row("8.7", 10, "best multiple of 5", "motor", 17.0),
    "S04.8": row("8.7", 14, BEST, "arm", 30.0),
    "S05.1": row("8.8", 1.05 * 5.32128, "k = 0", "17 Hz"),
    "S05.2": row("8.8", 0.548, LAST, "1 Hz"),  # as low as with a higher cutoff
    "S05.3": row("8.8", 1.557, LAST, "6 Hz"),
    "S05.4": row("8.8", 0.548, LAST, "17 Hz"),
    "S05.5": row("8.8", 0.05, "largest rise", "6 Hz"),
    "S05.6": row("8.8", 1.05 * 0.19854, EARLY, STATED),
    "S05.7": row("8.8", 0.95 * 5.32128, LAST, STATED),
    "S05.8": row("8.8", 1.05 * 0.19854, EARLY, LESS),
    "S05.9": row("8.8", 0.95 * 5.32128, LAST, LESS),
    "S06.1": row("8.9", 1.05 * 1.31447, NORM, 1),
    "S06.2": row("8.9", 1.05 * 0.6645, NORM, 2),
    "S06.3": row("8.9", 1.05 * 0.27668, NORM, 5),
    "S06.4": row("8.10", 1.05 * 1.46962, NORM, 0),
    "S06.5": row("8.10", 1.05 * 0.52199, NORM, 1),
    "S06.6": row("8.10", 1.05 * 0.13409, NORM, 5),
    "S06.7": row("8.11", 1.2, LAST, "motor", WRONG),
    "S06.8": row("8.11", 1.05 * 1.46962, LAST, "arm", IDEAL),  # no improvement
    "S06.9": row("8.11", 0.18, LAST, "arm", WRONG),  # as large as with the ideal filter
    "S06.10": row("8.12", 0.0, OVER, 0),
    "S06.11": row("8.12", 0.0, OVER, 500),
}


def section_8(id: str, *changed: tuple[str, Any, float]) -> list[Check]:
    """Checks of a section of chapter 8."""
    cells = {cell: value for section, cell, value in (*HELD_8, *changed) if section == id}
    table = Of(
        value=lambda column, *beginning: cells[column, *beginning],
        rows=[(c[1], c[2]) for c in cells if c[0] == GAMMA],
    )
    (entry,) = (entry for entry in chapter8.ENTRIES if entry.id == id)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(two_mass.FIGURES, id, lambda *_: table)
        gain = np.array([cells.get(("gain",), 0.0)])
        patch.setattr(chapter8, "largest_gamma", lambda *_: gain)
        return list(entry.make(Asked()).draw(None, Path()).checks)  # pyright: ignore[reportArgumentType]


# Chapter 5: results by name


FREQUENCY = np.arange(51.0)


def lines(*peaks: tuple[float, float]) -> np.ndarray:
    """A spectrum of y with lines at some frequencies [Hz] of some heights."""
    y = sum(height * np.exp(-((FREQUENCY - at) ** 2) / 4) for at, height in peaks)
    return np.stack([y, y, y], axis=1)


COUNT = 2 * np.pi / (2**12 - 1)  # [rad]
STEPS = COUNT * np.array([[0.0], [1.0], [0.0]]) * np.ones(6)
TURNS = np.array([[1.0], [-1.0]]) * [0.4, 0.4, 0.4, 0.5, 0.5, 0.5]
HELD_5: dict[str, Any] = {
    "off_rms": [0.01] * 3, "on_rms": [0.05] * 3, "on_level": [0.1, 0.3, 0.3],
    "frequency": FREQUENCY, "on_spectrum": lines((15, 1.0), (27, 0.4)),
    "tool": np.eye(4), "offset": [32.0, -26.0, 90.0], "tilt": 0.0, "site": 0.0,
    "clock_offset_error": 3e-4, "clock_errors": 1e-4 * np.array([-1.0, 1.0]),
    "turns": TURNS, "aided": 5.0, "unaided": 5.0, "motor_angle": STEPS, "gear": np.ones(6),
    "move_speed": np.array([0.5, 1.0]), "move_reached": np.array([0.5, 1.0]),
    "distances": [5e-4, 5e-4, 5e-4, 2e-5], "peers": 1e-15,
    "angular_velocity_rms": [0.01] * 3, "angular_velocity_max": [0.1] * 3,
    "acceleration_rms": [0.1] * 3, "acceleration_peak": [9.0, 9.0, 6.0], "clipped_share": 0.0,
    "acceleration_window_max": [0.3, 0.3, 0.2], "largest_in_rectangle": [1, 1, 0],
    "as_thesis_acceleration_window_max": [0.3, 0.4, 0.2],
    "as_thesis_largest_in_rectangle": [1, 1, 0], "fast_over_slow": 5.0,
}  # fmt: skip
CHAPTER_5: dict[str, tuple[str, Any]] = {  # by id: name, value
    "E01.1": ("offset", [32.0, -26.0, 90.5]),  # 0.5 mm away
    "E01.2": ("tilt", 0.01),
    "E01.3": ("site", 1e-5),
    "E02.1": ("off_rms", [0.05] * 3),
    "E02.2": ("on_rms", [0.0095] * 3),  # a fall of 5 %
    "E02.3": ("on_level", [0.1, 0.1, 0.3]),
    "E02.4": ("on_level", [0.1, 0.3, 0.1]),
    "E02.5": ("on_spectrum", lines((15, 1.0), (22, 0.4))),
    "E02.6": ("on_spectrum", lines((15, 0.95), (27, 1.0))),  # the highest, no small one
    "E03.1": ("motor_angle", 1.05 * STEPS),
    "E04.1": ("clock_offset_error", 1e-2),  # a sample
    "E04.2": ("clock_errors", 1e-3 * np.array([-0.9, 0.9])),
    "E04.3": ("clock_errors", 1e-3 * np.array([1.05, 1.05])),
    "E05.1": ("turns", 0.95 * TURNS),
    "E05.2": ("turns", 0.95 * TURNS),
    "E05.3": ("aided", 0.5),  # a tenth of the thesis's
    "E05.4": ("unaided", 0.5),
    "E06.1": ("move_reached", np.array([0.475, 1.0])),
    "E06.2": ("move_reached", np.array([0.5, 0.95])),
    "E06.3": ("motor_angle", STEPS + 0.01),
    **{
        f"E07.{i + 1}": ("distances", [1e-2 if i == j else 2e-5 for j in range(4)])
        for i in range(4)
    },
    "E07.5": ("peers", 1e-6),
    "E08.1": ("angular_velocity_rms", [0.01, 0.01, 0.1]),
    "E08.2": ("angular_velocity_max", [0.1, 0.1, 0.5]),
    "E09.1": ("acceleration_rms", [0.1, 0.5, 0.1]),
    "E09.2": ("acceleration_peak", [9.0, 10.5, 6.0]),
    "E09.3": ("acceleration_peak", [9.0, 8.0, 8.4]),
    "E09.4": ("clipped_share", 0.05),
    "E10.1": ("acceleration_window_max", [0.3, 0.84, 0.2]),
    "E10.2": ("acceleration_window_max", [0.2, 0.4, 0.21]),
    "E10.3": ("largest_in_rectangle", [1, 0, 0]),
    "E10.4": ("fast_over_slow", 0.95),
    "E10.5": ("as_thesis_acceleration_window_max", [0.84, 0.4, 0.2]),
    "E10.6": ("as_thesis_acceleration_window_max", [0.3, 0.84, 0.2]),
    "E10.7": ("as_thesis_acceleration_window_max", [0.36, 0.4, 0.38]),
    "E10.8": ("as_thesis_acceleration_window_max", [0.2, 0.4, 0.21]),  # larger than x alone
    "E10.9": ("as_thesis_largest_in_rectangle", [0, 1, 0]),
}


def chapter_5(**changed: Any) -> list[Check]:
    """All checks of chapter 5."""
    r = {name: np.asarray(value) for name, value in (HELD_5 | changed).items()}
    imu, names = np.eye(4), ("one", "two", "three", imu_checks.RIGID)
    imu[:3, 3], imu[0, 1] = 1e-3 * r["offset"], r["tilt"]
    turned = {"motor_angle": r["turns"]}
    runs = {n: {"tool_distance": d} for n, d in zip(names, r["distances"], strict=True)}
    return [
        *imu_checks.noise(r),
        *imu_checks.mounted(r["tool"], imu, imu[:3, 3] + r["site"]),
        *imu_checks.clocks(r),
        *imu_checks.one_at_a_time(turned, turned, r["aided"], r["unaided"]),
        *imu_checks.all_at_once(r),
        *imu_checks.distances(runs),
        imu_checks.toolbox_poses({"a toolbox": float(r["peers"])}),
        *imu_checks.rates(r),
        *imu_checks.accelerations(r),
        *imu_checks.windows(r),
    ]


# Papers: the last run of ten, where the run is not stated


def turned(name: str, factor: float, at: Any = -1, **of: Any) -> Change:
    """A measure of the jobs with these fields times a factor, in a run."""

    def change(job: Job, result: dict[str, Any]) -> None:
        if name in result and all(getattr(job, key, None) == value for key, value in of.items()):
            result[name] = np.array(result[name], dtype=float)
            result[name][at] *= factor

    return change


RIGHT, STIFF = {"error": "right"}, {"error": "k + 15 %"}
MOTORS, ESTIMATED = {"measure": "motor"}, {"measure": "estimate"}
SQUARE: dict[str, Change] = {  # of both arms
    "T1-acceleration-motor": turned("acceleration_rms", 0.95 / 1.4, **MOTORS),  # a fall of 5 %
    "T1-acceleration-load": turned("acceleration_rms", 1.05 / 0.4, **ESTIMATED),
    "T1-tcp": turned("tcp_rms", 1.05 / 0.4, **ESTIMATED),
    "T1-tcp-order": turned("tcp_rms", 1.45 / 0.4, individual=100, **ESTIMATED),  # one of three
    "T1-rest": turned("rest_acceleration_rms", 0.95 / 2.8, **MOTORS),
    "T1-peak": turned("tcp_peak", 1.05 / 0.4, **ESTIMATED),
    "T1-peak-motor": turned("tcp_peak", 0.5 / 1.4, **MOTORS),
}
PAPERS: dict[str, tuple[str, Change]] = {
    "bench-first": ("papers-bench", turned("reference", 1.2, (0, 0), **RIGHT)),
    "bench-first-peak": ("papers-bench", turned("reference", 0.8, (0, 1), **RIGHT)),
    "bench-ten": ("papers-bench", turned("torque M", 2.1, **RIGHT)),
    "bench-wrong": ("papers-bench", turned("torque M", 0.5, **STIFF)),  # one error of six
    "bench-wrong-load": ("papers-bench", turned("torque L", 6.0, **STIFF)),
    "T3-dkf": ("papers-estimators", turned("dkf", 1.7, ())),  # a wrong model costs nothing
    "T3-kkf": ("papers-estimators", turned("kkf", 2.1, ())),  # the gyroscope makes it worse
    **{
        f"T1-two-stage-{id}": ("papers-two-stage", change)
        for id, change in {
            "motor": turned("acceleration_rms", 0.95 / 1.4, side="motor"),
            "load": turned("acceleration_rms", 1.05 / 0.4, side="load"),
            "tcp": turned("tcp_rms", 1.05 / 0.4, side="load"),
            "peak": turned("tcp_peak", 1.05 / 0.4, side="load"),
            "rest": turned("rest_acceleration_rms", 0.95 / 2.8, side="motor"),
        }.items()
    },
    "T2-smoother": ("papers-tool", turned("smoother", 1.05 / 0.4, 0)),  # no better than motors
    "T2-online": ("papers-tool", turned("online", 1.05 / 0.5, 0)),
    "T2-doubled": ("papers-tool", turned("smoother doubled", 1.05 / 0.45, 0)),
    "T2-doubled-loss": ("papers-tool", turned("smoother doubled", 0.8 / 0.45, 0)),  # costs as much
    "L1": ("papers-edge", turned("position", 1.05 / 0.4, 1)),  # worse than uncorrected
    "L1-peak": ("papers-edge", turned("peak", 1.05 / 0.5, 1)),
    "L1-acceleration": ("papers-edge", turned("acceleration", 1.05 / 0.6, 1)),
    "N1": ("papers-speeds", turned("twin", 2.1 / 0.8, ())),
    **{
        f"{id}{suffix}": (f"papers-square{suffix}", change)
        for suffix in ("", "-large")
        for id, change in SQUARE.items()
    },
}


def section_papers(id: str, change: Change | None = None) -> list[Check]:
    """Checks of a section on papers."""

    def read(job: Job) -> dict[str, Any]:
        made = as_in_papers(job)
        if change is not None:
            change(job, made)
        return made

    @contextmanager
    def panels(*_: Any, **__: Any) -> Iterator[list[MagicMock]]:
        of_learning = id.startswith(("papers-square", "papers-two-stage"))
        yield [MagicMock()] * (3 if of_learning else 2 if id == "papers-bench" else 1)

    (entry,) = (entry for entry in chapter_papers.ENTRIES if entry.id == id)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(chapter_papers, "panels", panels)
        patch.setattr(chapter_papers, "logarithmic", lambda *_: None)
        return list(entry.make(Asked()).draw(read, Path()).checks)


# Real arms: what the analysis of the measurements gives


HELD_REAL: dict[str, float] = {  # mm, ratios, degrees; docs/real.md
    "geometry": 0.43, "full": 0.11, "p95": 0.2, "fifty": 0.2, "rank": 27, "irb120": 0.35,
    "rank of irb120": 33, "scale": 0.003, "mounting": 0.1, "gear": 0.65, "worst gear": 0.75,
    "fused": 0.65, "sham": 1.0, "scatter": 0.1,
}  # fmt: skip
REAL: dict[str, tuple[str, str, float]] = {  # by id: section, name, value
    "R1.1": ("real-ur10", "geometry", 0.92),  # of the nominal robot
    "R1.2": ("real-ur10", "full", 0.43),  # of the geometry alone
    "R1.3": ("real-ur10", "p95", 0.43),
    "R1.4": ("real-ur10", "fifty", 0.43),
    "R1.5": ("real-ur10", "rank", 26),
    "R2.1": ("real-irb120", "irb120", 0.42),
    "R2.2": ("real-irb120", "rank of irb120", 32),
    "R3.1": ("real-imu", "scale", 0.0053),
    "R3.2": ("real-imu", "mounting", 0.21),
    "R4.1": ("real-gears", "gear", 1.05),  # the estimate makes it worse
    "R4.2": ("real-gears", "worst gear", 1.05),
    "R4.3": ("real-gears", "fused", 1.05),
    "R4.4": ("real-gears", "sham", 0.95),  # sham orders help
    "R5.1": ("real-paths", "scatter", 0.16),
}


def section_real(id: str, **changed: float) -> list[Check]:
    """Checks of a section on a real arm."""
    v = HELD_REAL | changed
    draws = iter([v["full"], *[v["fifty"]] * 5] if id == "real-ur10" else [v["irb120"]])
    rank = v["rank" if id == "real-ur10" else "rank of irb120"]

    def calibrate(*_: Any, **__: Any) -> Any:
        mean = next(draws)
        errors = {"nominal": 0.92, "geometry": v["geometry"], "full": mean}
        of = {name: Errors(1e-3 * m, 1e-3 * v["p95"], 2e-3) for name, m in errors.items()}
        return Of(errors=of.__getitem__, identifiable=Of(all=Of(rank=rank)))

    ones = [
        Of(tool=Of(pooled=tool), sham_tool=Of(pooled=v["sham"]), smoothed=Of(pooled=v["fused"]),
           bands=[], recording="a day")
        for tool in (0.6, v["gear"], v["worst gear"])
    ]  # fmt: skip
    vector = np.ones(3)
    day = Of(
        alignment=None, name="a day",
        comparison=Of(time=0, angular_velocity_measured=0, angular_velocity_predicted=0),
        measures=Of(angular_velocity_error=vector, angular_velocity=vector,
                    acceleration_error=vector, acceleration=vector),
    )  # fmt: skip
    perfect = np.ones(2)
    speed = Of(
        real=Of(scatter=1.0 + v["scatter"], error_in_plane=1.0), perfect=perfect, speed=1.0,
        virtual=Of(scatter=1.0, error_in_plane=1.0),
    )  # fmt: skip
    found = Of(gyro_scale=v["scale"], mounting=np.radians(v["mounting"]))
    with pytest.MonkeyPatch.context() as patch:
        for name, given in {
            "calibrate": calibrate, "read_poses": lambda *_: Of(measurements=None, notes=()),
            "_days": lambda *_: [0, 1], "process": lambda *_: day,
            "repeatability": lambda *_: found,
            "analyse_gears": lambda *_: Of(judgements=ones), "read_path_logs": lambda *_: None,
            "compare_logs": lambda *_: Of(speeds=[speed]),
        }.items():  # fmt: skip
            patch.setattr(chapter_real, name, given)
        silent(patch, chapter_real.of_calibration, chapter_real.of_gears)
        silent(patch, chapter_real.of_imu, chapter_real.of_paths)
        return list(chapter_real.SETS[id][1](0, Path(), Path()).checks)


# The table and what it says


@cache
def held() -> dict[str, Check]:
    """Every check of every section, from results for which they hold."""
    checks = [*chapter_5()]
    of = {"8": section_8, "9": section_9, "papers": section_papers, "real": section_real}
    for chapter, section in of.items():
        ids = [entry.id for entry in chapters()[chapter] if chapter != "8" or not entry.alone]
        checks += [check for id in ids for check in section(id)]
    return {check.id: check for check in checks}


def opposite(id: str) -> list[Check]:
    """The checks of the section, with the change of the table."""
    if id in CHAPTER_9:
        return section_9(*CHAPTER_9[id])
    if id in MODELS:
        return bands.criterion_of(*MODELS[id])
    if id in CHAPTER_8:
        return section_8(CHAPTER_8[id][0], CHAPTER_8[id])
    if id in PAPERS:
        return section_papers(*PAPERS[id])
    if id in REAL:
        section, name, value = REAL[id]
        return section_real(section, **{name: value})
    name, value = CHAPTER_5[id]
    return chapter_5(**{name: value})


IDS = [*CHAPTER_5, *CHAPTER_8, *CHAPTER_9, *MODELS, *PAPERS, *REAL]


def test_every_check_of_a_report_is_in_the_table():
    assert sorted(held()) == sorted(IDS)


@pytest.mark.parametrize("id", IDS)
def test_the_opposite_of_a_sentence_fails_it(id):
    assert held()[id].verdict == "holds", held()[id]
    (turned,) = (check for check in opposite(id) if check.id == id)
    assert turned.verdict == "FAILS", turned
    assert np.isfinite(turned.ours)

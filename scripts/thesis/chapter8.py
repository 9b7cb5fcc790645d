"""Chapter 8 of the thesis, figure by figure: a flexible joint that learns, and what is compared.

Where the thesis prints a number, the band is that number. Where it shows a curve, the band is what
another implementation of its equations gives, as wide as the two may differ.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

from armside.ilc.analysis import largest_gamma
from armside.ilc.chapter8 import SHIFTS
from armside.sim.evaluation.check import Check, Table

from ..figures.two_mass import (
    AS_STATED,
    AT_THESIS_SHIFT,
    FIGURES,
    LOOP,
    ONE_LESS,
    THESIS_SHIFT,
)
from ..jobs.store import Job, Result
from .report import Part, Section

GRID_STEP = 0.0022
"""Between the frequencies of Fig. 8.3 near 1.2 Hz [Hz]."""
NORMS = 2e-3
"""Of 2-norms over 500 iterations, relative."""
LEFT_AFTER_500 = {"1 Hz": (1.557, 1e-2), "6 Hz": (0.548, 1e-3), "17 Hz": (0.19854, NORMS)}
"""By cutoff of Q: 2-norm of the motor error [rad], and its relative tolerance. A low cutoff has
more to do with the ends of the record, where implementations differ."""

NOT_11_HZ = (
    "no gain of 0.5 to 1.5, order of Q, discretisation or delay of the loop that was tried gives "
    "11, 22 and 38 Hz together; at 11 Hz shifts of 2, 4 and 6 meet the criterion with room to spare"
)
NOT_SHIFT_5 = (
    "the best shift falls from 12 to 4 as the cutoff rises from 5 to 30 Hz, and is 5 only near "
    "25 Hz. From 10 Hz on, 5 is the best multiple of five, as if the search had gone in such steps"
)
NOT_DELTA_5 = (
    "with the shift of 5 that the thesis states, the error is smallest at k = 14 and grows by "
    "2.7 % an iteration; the curve it shows is that of a shift of 4, or of one more delay in the "
    "loop"
)


def _part(
    name: str, title: str, caption: str, compare: Callable[[Table], Sequence[Check]], seed: int
) -> Part:
    """Nothing is run before: the figure is drawn, and its table compared."""

    def draw(read: Callable[[Job], Result], folder: Path) -> Section:
        table = FIGURES[name](folder / f"{name}.png", seed)
        return Section(
            id=name,
            title=f"Fig. {name}: {title}",
            caption=caption,
            figures=[f"{name}.png"],
            checks=compare(table),
            tables=[table],
        )

    return Part([], draw)


def _computed(
    id: str, statement: str, says: str, ours: float, value: float, tolerance: float
) -> Check:
    """A number that the thesis does not print: what it says, and the value of its equations."""
    return Check(
        id=id,
        statement=statement,
        thesis=f"{says}; its equations: {value:g}",
        ours=ours,
        low=value - tolerance,
        high=value + tolerance,
    )


def _norm(id: str, statement: str, says: str, ours: float, value: float) -> Check:
    """A 2-norm over the record [rad]."""
    return _computed(id, statement, says, ours, value, NORMS * value)


def joint(seed: int) -> Part:
    """Fig 8.3."""

    def compare(table: Table) -> list[Check]:
        notch = "notch of the motor, G_m"
        at, shown = "frequency [Hz]", "magnitude [dB]"
        peak = table.value(at, "peak of the arm, G_a")
        root = table.value(at, "zeros of G_m(s) = poles of G_a(s)")
        return [
            _computed(
                "S01.1", "notch of G_m [Hz]", "near 1", table.value(at, notch), 1.1978, GRID_STEP
            ),
            _computed(
                "S01.2", "its magnitude [dB]", "a curve", table.value(shown, notch), -19.5, 1e-3
            ),
            _computed("S01.3", "peak of G_a [Hz]", "at the notch", peak, 1.0983, GRID_STEP),
            _computed(
                "S01.4", "zeros of G_m(s) and poles of G_a(s) [Hz]", "the same", root, 1.1305, 1e-4
            ),
        ]

    return _part(
        "8.3",
        "the discrete joint",
        "From voltage to motor angle, from motor to arm angle, and both together. The motor has a "
        "notch where the arm has its peak: the zeros of the one are the poles of the other. The "
        "lowest and the highest point that the eye sees lie 0.1 Hz apart, because the motor's "
        "other poles tilt its curve.",
        compare,
        seed,
    )


def reference(seed: int) -> Part:
    """Fig 8.4."""

    def compare(table: Table) -> list[Check]:
        return [
            Check(
                id="S02.1",
                statement="largest speed of the arm reference [rad/s]",
                thesis="between 2 and 3, by its axis",
                ours=table.value("value", "largest speed [rad/s]"),
                low=2.0,
                high=3.0,
            )
        ]

    return _part(
        "8.4",
        "the arm reference",
        "A step made smooth: constant acceleration, then the same deceleration. The thesis prints "
        "neither its start nor its length; here it begins at 1 s and takes 0.8 s.",
        compare,
        seed,
    )


def tracking(seed: int) -> Part:
    """Fig 8.5."""

    def compare(table: Table) -> list[Check]:
        norm = "2-norm of the error [rad]"
        overshoot = table.value("overshoot [rad]", "arm")
        return [
            Check(
                id="S02.2",
                statement="where the motor reference ends [rad]",
                thesis="5",
                ours=table.value("reference ends at [rad]", "motor"),
                low=5.0 - 1e-6,
                high=5.0 + 1e-6,
            ),
            _norm("S02.3", "motor error, 2-norm", "a curve", table.value(norm, "motor"), 5.32128),
            _norm(
                "S02.4",
                "arm error, 2-norm",
                "follows satisfactorily",
                table.value(norm, "arm"),
                1.46962,
            ),
            _computed("S02.5", "overshoot of the arm [rad]", "a curve", overshoot, 0.0413, 1e-4),
        ]

    return _part(
        "8.5",
        "tracking without learning",
        "Feedback alone: both sides lag behind their references. The motor turns five times as far "
        "as the arm, which is the gear ratio.",
        compare,
        seed,
    )


def criterion(seed: int) -> Part:
    """Fig 8.6."""

    def compare(table: Table) -> list[Check]:
        printed = {0: 11.0, 2: 22.0, 4: 38.0}
        lowest = min(table.value("max |1-LTu| [dB]", delta) for delta in (0, 2, 4, 6))
        return [
            Check(
                id="S03.1",
                statement="smallest of four shifts: largest |1 - L T_u| [dB]",
                thesis="above 0: each shift needs a Q",
                ours=lowest,
                low=1e-3,
            ),
            Check(
                id="S03.2",
                statement="largest gain that meets the criterion with Q = 1, shifts of -50 to 50",
                thesis="none",
                ours=float(largest_gamma(LOOP.T_motor, SHIFTS, None).max()),
                high=0.0,
            ),
            *(
                Check(
                    id=f"S03.{i}",
                    statement=f"largest cutoff of Q with which a shift of {delta} converges [Hz]",
                    thesis=f"about {cutoff:g}",
                    ours=table.value("largest cutoff [Hz]", delta),
                    low=cutoff - 0.5,
                    high=cutoff + 0.5,
                    reason=NOT_11_HZ if delta == 0 else "",
                )
                for i, (delta, cutoff) in enumerate(printed.items(), start=3)
            ),
        ]

    return _part(
        "8.6",
        "the convergence criterion",
        "Each solid curve must stay below the dashed curve of the filter that is used. With Q = 1 "
        "the bound is 0 dB, and every shift crosses it. The thesis draws filters of about 11, 22 "
        "and 38 Hz without saying which shift they belong to: 22 and 38 Hz are the highest for "
        "shifts of 2 and 4.",
        compare,
        seed,
    )


def admissible_gain(seed: int) -> Part:
    """Fig 8.7."""

    def compare(table: Table) -> list[Check]:
        cutoffs = sorted({row[1] for row in table.rows})
        motor, arm = (
            [table.value("gamma |Tu(0)|", side, cutoff) for cutoff in cutoffs]
            for side in THESIS_SHIFT
        )
        gain = {
            (side, cutoff): table.value(AT_THESIS_SHIFT, side, cutoff)
            for side in THESIS_SHIFT
            for cutoff in (0.5, 1.0)
        }
        return [
            Check(
                id="S04.1",
                statement="motor, 0.5 Hz, shift 5: largest gain",
                thesis="2",
                ours=gain["motor", 0.5],
                low=2.0 - 2e-4,
                high=2.0 + 2e-4,
            ),
            _computed(
                "S04.2",
                "motor, 1 Hz, shift 5: largest gain",
                "below 2",
                gain["motor", 1.0],
                1.9987,
                1e-4,
            ),
            _computed(
                "S04.3",
                "arm, 0.5 Hz, shift 15: largest gain",
                "10 in the limit, below 1 Hz",
                gain["arm", 0.5],
                9.7856,
                5e-3,
            ),
            _computed(
                "S04.4",
                "arm, 1 Hz, shift 15: largest gain",
                "less",
                gain["arm", 1.0],
                5.4308,
                5e-3,
            ),
            Check(
                id="S04.5",
                statement="gain times static gain, arm over motor: largest in the table",
                thesis="lower for the arm",
                ours=max(a / m for a, m in zip(arm, motor, strict=True)),
                high=1.0,
            ),
            _shift("S04.6", "motor, 17 Hz: best shift", table, "best delta", "motor", 17.0),
            _shift(
                "S04.7",
                "motor, 17 Hz: best of the multiples of five",
                table,
                "best multiple of 5",
                "motor",
                17.0,
            ),
            _shift("S04.8", "arm, 30 Hz: best shift", table, "best delta", "arm", 30.0),
        ]

    return _part(
        "8.7",
        "the admissible gain over shift and cutoff",
        "The largest gain that meets the criterion, times the static gain, so that both sides "
        "compare. Learning from the arm angle is harder: its response has a peak near 1 Hz, and "
        "only a filter below it leaves the gain that the static gain would allow. Of all shifts, "
        "15 lasts up to the highest cutoff on the arm side; at lower ones larger shifts admit "
        "more.",
        compare,
        seed,
    )


def _shift(id: str, statement: str, table: Table, column: str, side: str, cutoff: float) -> Check:
    """A best shift [samples] against the one the thesis names for that side."""
    expected = THESIS_SHIFT[side]
    return Check(
        id=id,
        statement=statement,
        thesis=f"{expected}",
        ours=table.value(column, side, cutoff),
        low=expected,
        high=expected,
        reason=NOT_SHIFT_5 if side == "motor" else "",
    )


def learning_curves(seed: int) -> Part:
    """Fig 8.8."""

    def compare(table: Table) -> list[Check]:
        left = {name: table.value("k = 500", name) for name in LEFT_AFTER_500}
        rise = max(left[name] / table.value("smallest", name) - 1.0 for name in left)
        first = table.value("k = 0", "17 Hz")
        return [
            _norm("S05.1", "error before learning, 2-norm [rad]", "a curve", first, 5.32128),
            *(
                _computed(
                    f"S05.{i}",
                    f"{name}: error after 500 iterations, 2-norm [rad]",
                    "lower the higher the cutoff",
                    left[name],
                    value,
                    tolerance * value,
                )
                for i, (name, (value, tolerance)) in enumerate(LEFT_AFTER_500.items(), start=2)
            ),
            Check(
                id="S05.5",
                statement="with Q: by how much the last error exceeds the smallest, worst of three",
                thesis="decreases monotonically",
                ours=rise,
                high=0.01,
            ),
            *_without_q("S05.6", "S05.7", "Q = 1, shift 5", AS_STATED, table),
            *_without_q("S05.8", "S05.9", "Q = 1, shift 4", ONE_LESS, table),
        ]

    return _part(
        "8.8",
        "500 iterations without and with Q",
        "Without Q the error falls below what a filter leaves, and then grows without end. With "
        "Q it stays, and the lower the cutoff, the more is left. What shrinks in every iteration "
        "is the distance from what is left; the error itself may dip below it, at 1 Hz by 0.6 %.",
        compare,
        seed,
    )


def _without_q(early: str, late: str, run: str, name: str, table: Table) -> list[Check]:
    """Better than with Q when stopped at 25 iterations, and within the axis after 500."""
    return [
        Check(
            id=early,
            statement=f"{run}: error at k = 25 over that of 17 Hz at k = 500",
            thesis="lower",
            ours=table.value("k = 25", name) / table.value("k = 500", "17 Hz"),
            high=1.0,
            reason=NOT_DELTA_5,
        ),
        Check(
            id=late,
            statement=f"{run}: error at k = 500 over its first",
            thesis="grows, to less than 100 by its axis",
            ours=table.value("k = 500", name) / table.value("k = 0", name),
            low=1.0,
            high=100.0,
            reason=NOT_DELTA_5,
        ),
    ]


def motor_signals(seed: int) -> Part:
    """Fig 8.9."""

    def compare(table: Table) -> list[Check]:
        says = "follows well after a couple of iterations"
        return [
            _norm(f"S06.{i}", f"motor error at k = {k}, 2-norm [rad]", says, ours, value)
            for i, (k, value) in enumerate({1: 1.31447, 2: 0.6645, 5: 0.27668}.items(), start=1)
            for ours in [table.value("2-norm [rad]", k)]
        ]

    return _part(
        "8.9",
        "the motor angle while it learns",
        "Motor angle and reference above, their difference below, before learning and after one, "
        "two and five updates with a gain of 0.9, a shift of 5 and 17 Hz.",
        compare,
        seed,
    )


def arm_signals(seed: int) -> Part:
    """Fig 8.10."""

    def compare(table: Table) -> list[Check]:
        return [
            _norm(f"S06.{i}", f"arm error at k = {k}, 2-norm [rad]", "improved", ours, value)
            for i, (k, value) in enumerate({0: 1.46962, 1: 0.52199, 5: 0.13409}.items(), start=4)
            for ours in [table.value("2-norm [rad]", k)]
        ]

    return _part(
        "8.10",
        "the arm angle while the motor learns",
        "The same runs seen on the arm. The filter that turns the arm reference into one for the "
        "motor is exact, so the arm improves with the motor. What remains is the one sample by "
        "which that filter is late.",
        compare,
        seed,
    )


def model_error(seed: int) -> Part:
    """Fig 8.11."""

    def compare(table: Table) -> list[Check]:
        def value(k: int, side: str, model: str) -> float:
            return table.value(f"k = {k}", side, model)

        def better(model: str) -> float:
            return value(0, "arm", model) / value(500, "arm", model)

        last = [value(500, "motor", model) for model in ("model error", "ideal model")]
        return [
            Check(
                id="S06.7",
                statement="motor error at k = 500, 2-norm: doubled stiffness over ideal",
                thesis="almost the same",
                ours=last[0] / last[1],
                low=0.9,
                high=1.1,
            ),
            _computed(
                "S06.8",
                "arm error at k = 0 over k = 500, 2-norm, ideal filter",
                "improved",
                better("ideal model"),
                1.46962 / 0.12913,
                2.0 * NORMS * 1.46962 / 0.12913,
            ),
            _computed(
                "S06.9",
                "the same, doubled stiffness in the filter",
                "a smaller improvement",
                better("model error"),
                2.04878 / 1.0285,
                2.0 * NORMS * 2.04878 / 1.0285,
            ),
        ]

    return _part(
        "8.11",
        "a wrong model of the arm",
        "The filter from arm to motor reference now believes in a spring of twice the stiffness. "
        "The motor learns as before; the arm, which nobody measures, gains little. This is the "
        "reason for everything the thesis does with estimates of the tool afterwards.",
        compare,
        seed,
    )


def arm_signals_with_error(seed: int) -> Part:
    """Fig 8.12."""

    def compare(table: Table) -> list[Check]:
        return [
            _computed(
                f"S06.{i}",
                f"overshoot of the arm at k = {k} [rad]",
                says,
                table.value("overshoot [rad]", k),
                value,
                1e-4,
            )
            for i, k, says, value in (
                (10, 0, "oscillates", 0.1555),
                (11, 500, "not sufficiently reduced", 0.1456),
            )
        ]

    return _part(
        "8.12",
        "the arm angle with a wrong model",
        "The arm oscillates before learning and after it: the correction removes what is slow, and "
        "the oscillation is not seen by the motor.",
        compare,
        seed,
    )

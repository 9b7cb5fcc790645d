"""Pictures of an episode as pixels: drawn in software, or MuJoCo's view of the robot."""

from collections.abc import Sequence

import numpy as np

from .rules import Rules
from .situation import RewardSensor, Situation

WIDTH, HEIGHT, DPI = 640, 320, 80
MAGNIFICATIONS = (20.0, 10.0, 5.0, 2.0)
"""Largest magnification of the deviation from the programmed contour."""
LARGEST_SHOWN = 0.6
"""Fraction of the smallest radius of the contour."""


def _drawing(history: Sequence[Situation], rules: Rules) -> np.ndarray:
    """Contour and errors over the iterations."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    figure = Figure((WIDTH / DPI, HEIGHT / DPI), dpi=DPI, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    contour, errors = figure.subplots(1, 2, width_ratios=(1.0, 1.1))
    curve = history[0].experiment.motion.curve
    factor = magnification(history, curve.smallest_radius)
    programmed = curve.point(np.linspace(0.0, curve.length, 361))
    contour.plot(*(1e3 * programmed.T), "k:", lw=1)
    for situation in history:
        path = situation.measured.path
        shown = path + (factor - 1.0) * (path - curve.point(curve.nearest(path)))
        newest = situation is history[-1]
        contour.plot(*(1e3 * shown.T), lw=1.5 if newest else 0.7, color="C3" if newest else "0.7")
    contour.set_aspect("equal")
    beside = (0.05 + LARGEST_SHOWN) * curve.smallest_radius
    edge = 1e3 * (np.abs(programmed).max() + beside)
    contour.set(xlim=(-edge, edge), ylim=(-edge, edge))
    label = RewardSensor(rules.reward).label
    contour.set_title(f"tool {label}, deviation x {factor:g} [mm]", fontsize=8)
    k = [situation.k for situation in history]
    norms = np.array([situation.two_norm / situation.first_norm for situation in history])
    for i, motor in enumerate(norms.T):
        errors.semilogy(k, motor, ".-", lw=1, label=f"motor {i + 1}")
    rms = np.array([situation.measured.rms for situation in history])
    errors.semilogy(k, rms / rms[0], "k.-", lw=2, label="tool RMS")
    end = ", diverged" if history[-1].diverged else ""
    errors.set_title(f"errors over those at k = 0{end}", fontsize=8)
    errors.set_xlabel("iteration k", fontsize=8)
    errors.set_xticks(range(rules.iterations + 1))
    errors.set_xlim(-0.2, rules.iterations + 0.2)
    errors.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    errors.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    errors.yaxis.set_minor_formatter(NullFormatter())
    errors.legend(fontsize=6, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    for axes in (contour, errors):
        axes.tick_params(labelsize=7)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def magnification(history: Sequence[Situation], radius: float) -> float:
    """Magnification of the measured deviations from a contour of that smallest radius [m]."""
    largest = max(np.nan_to_num(situation.measured.maxdev) for situation in history)
    return next((m for m in MAGNIFICATIONS if m * largest <= LARGEST_SHOWN * radius), 1.0)


def _robot(history: Sequence[Situation], rules: Rules) -> np.ndarray:
    """The robot where its run starts; needs OpenGL, in software or hardware."""
    import mujoco

    from ..replay.offscreen import Offscreen, drawn_model, named_camera

    loaded = history[-1].experiment.loaded
    mj = drawn_model(loaded.model.mj, rules.cell.xml)
    data = mujoco.MjData(mj)
    data.qpos[:] = loaded.initial_state[1 : 1 + mj.nq]
    mujoco.mj_forward(mj, data)
    with Offscreen(mj, WIDTH, HEIGHT) as camera:
        return camera.draw(data, named_camera(mj, "whole"))


PICTURES = {"drawing": _drawing, "mujoco": _robot}
"""Content of `render`: (height, width, 3) uint8 of an episode so far. Raises NoGraphicsError where
MuJoCo cannot draw."""

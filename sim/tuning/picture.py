"""Pictures of an episode as pixels: drawn in software, or MuJoCo's view of the robot."""

from collections.abc import Sequence
from enum import Enum

import numpy as np

from .situation import Situation

WIDTH, HEIGHT, DPI = 640, 320, 80
MAGNIFIED = 20.0
"""Deviation from the programmed circle."""


class Picture(Enum):
    """What `render` shows."""

    DRAWING = "drawing"
    """Circle and errors over the iterations."""
    MUJOCO = "mujoco"
    """The robot where its run starts; needs GL."""

    def draw(self, history: Sequence[Situation]) -> np.ndarray:
        """(height, width, 3) uint8."""
        return _robot(history[-1]) if self is Picture.MUJOCO else _drawing(history)

    @classmethod
    def _missing_(cls, value: object) -> None:
        raise ValueError(
            f"Unknown picture {value!r}. It can be: {', '.join(p.value for p in Picture)}"
        )


def _drawing(history: Sequence[Situation]) -> np.ndarray:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure((WIDTH / DPI, HEIGHT / DPI), dpi=DPI, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    circle, errors = figure.subplots(1, 2)
    radius = history[0].experiment.task.curve.smallest_radius
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circle.plot(1e3 * radius * np.cos(turn), 1e3 * radius * np.sin(turn), "k:", lw=1)
    for situation in history:
        path = situation.seen.path
        distance = np.hypot(*path.T)
        shown = path * (1.0 + (MAGNIFIED - 1.0) * (1.0 - radius / distance))[:, None]
        newest = situation is history[-1]
        circle.plot(*(1e3 * shown.T), lw=1.5 if newest else 0.7, color="C3" if newest else "0.7")
    circle.set_aspect("equal")
    circle.set_title(f"tool, deviation x {MAGNIFIED:g} [mm]", fontsize=9)
    k = [situation.k for situation in history]
    first = history[0].first_norm
    norms = np.array([situation.two_norm / first for situation in history])
    for i, motor in enumerate(norms.T):
        errors.semilogy(k, motor, ".-", lw=1, label=f"motor {i + 1}")
    rms = np.array([situation.seen.rms for situation in history])
    errors.semilogy(k, rms / rms[0], "k.-", lw=2, label="tool RMS")
    errors.set_title("errors over those at k = 0", fontsize=9)
    errors.set_xlabel("k", fontsize=8)
    errors.legend(fontsize=6)
    for axes in (circle, errors):
        axes.tick_params(labelsize=7)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def _robot(situation: Situation) -> np.ndarray:
    import mujoco

    job = situation.experiment.job
    data = mujoco.MjData(job.model.mj)
    mujoco.mj_setState(
        job.model.mj, data, job.initial_state, int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
    )
    mujoco.mj_forward(job.model.mj, data)
    with mujoco.Renderer(job.model.mj, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data)
        return renderer.render()

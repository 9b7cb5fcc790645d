"""Why the tool does not follow when the motors do: spectra of both errors, and the arm's modes."""

from pathlib import Path

import numpy as np

from armside.arrays import Array
from armside.scripts.figures.canvas import (
    COLORS,
    MARKERS,
    REFERENCE,
    logarithmic,
    panels,
    whole_numbers,
)
from armside.sim.estimation.linearised_arm import LinearisedArm, linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.records import read_run
from armside.sim.replay.run_scene import stored_scene
from armside.sim.robot.model import RobotModel

LINE = "laser"
SHOWN_TO = 20.0
"""Largest frequency [Hz]; above it both errors are below 1 um."""
N_MODES = 3


def draw(run: Path, file: Path) -> None:
    """Motors on the left, tool on the right, at k = 0 and at the end."""
    stored = read_run(run)
    scene = stored_scene(stored)
    robot, contours = prepare(Cut()).loaded.model, scene.contours
    middle = contours[0].cutting.nonzero()[0].mean().astype(int)
    arm = linearised(
        nominal_arm(robot, NominalCfg(structure=True)), scene.runs[0].recording.motor_angle[middle]
    )
    held, servo = held_modes(arm)[:N_MODES], servo_modes(arm, robot)
    near = [servo[np.abs(servo[:, 0] - f).argmin(), 1] for f in held[:, 0]]
    ratios = [", ".join(f"{100 * ratio:.2g}" for ratio in each) for each in (held[:, 1], near)]
    modes = f"modes, motors held: {', '.join(f'{f:.1f}' for f in held[:, 0])} Hz"
    damping = f"{modes}; damping {ratios[0]} %, by the servo {ratios[1]} %"
    cutoff = max(stored.summary["config"]["cutoff"])
    title = "Deviation across the path by frequency, before and after learning from the motors"
    with panels(file, (9.6, 4.6), 1, 2, sharex=True, sharey=True, title=title) as grid:
        for axes, side in zip(grid, ("motor", "tool"), strict=True):
            axes.axvspan(0.0, cutoff, color="#F0F0F0", lw=0, label=f"learned: below {cutoff:g} Hz")
            for frequency, _ in held:
                axes.axvline(frequency, color=REFERENCE, lw=1.0, ls=(0, (4, 3)))
            for i in (0, -1):
                f, amplitude = contours[i].spectrum(getattr(contours[i], side))
                shown, k = f <= SHOWN_TO, scene.runs[i].k
                look = {"color": COLORS[1 + i], "marker": MARKERS[1 + i], "label": f"k = {k}"}
                axes.plot(f[shown], 1e6 * amplitude[shown], ms=4, lw=1.3, **look)
            axes.lines[0].set_label(damping)
            whole_numbers(axes.xaxis)
            axes.set(xlabel="frequency [Hz]", xlim=(0.0, SHOWN_TO))
            logarithmic(axes)
            axes.grid(True)
        grid[0].set_ylabel("amplitude [µm]")
        grid[0].set_title("Motors: where they alone would put the tool")
        grid[1].set_title("Tool: where it truly is")
        handles, labels = grid[0].get_legend_handles_labels()
        grid[0].figure.legend(handles, labels, loc="outside lower center", ncols=2)


def held_modes(arm: LinearisedArm) -> Array:
    """(m, 2) frequency [Hz], ascending, and damping ratio with the motors held."""
    return _modes(arm.dynamics()[0])


def servo_modes(arm: LinearisedArm, robot: RobotModel) -> Array:
    """As `held_modes`, where the motors yield: linear servo and rotor, without Coulomb friction.

    J phi'' = -kp phi - (kd + b) phi' + K (q - phi) + D (q' - phi'), arm side of the gears.
    """
    drives, n, a = robot.drives, arm.n_free, len(arm.axes)
    dof = [robot.mj.joint(f"motor_{i + 1}").dofadr[0] for i in range(a)]
    J, g2 = robot.mj.dof_armature[dof], drives.gear**2
    spring, damper = np.diag(arm.stiffness / J), np.diag(arm.damping / J)
    A = np.zeros((2 * (n + a), 2 * (n + a)))
    A[: 2 * n, : 2 * n], A[: 2 * n, 2 * n :] = arm.dynamics()
    A[2 * n : 2 * n + a, 2 * n + a :] = np.eye(a)
    yielding = A[2 * n + a :]
    yielding[:, arm.axes], yielding[:, n + arm.axes] = spring, damper
    yielding[:, 2 * n : 2 * n + a] = -spring - np.diag(drives.kp * g2 / J)
    yielding[:, 2 * n + a :] = -damper - np.diag((drives.kd + drives.viscous_friction) * g2 / J)
    return _modes(A)


def _modes(A: Array) -> Array:
    poles = np.linalg.eigvals(A)
    poles = poles[poles.imag > 1e-6]
    size = np.abs(poles)
    return np.column_stack([size / (2.0 * np.pi), -poles.real / size])[size.argsort()]

"""Measurement equations of the motor encoders and an IMU, as functions of the motion. Row F01.

y = (motor angles, angular velocity, specific force): the encoder of each motor, and a gyro and an
accelerometer in the axes of a link's frame. The accelerometer reads R^T (a - gravity).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..dh import Robot
from ..expressions.symbols import exact
from .chain import ZERO, Vector, added, lever_acceleration, times
from .coupling import joint_rates, joint_variables, motor_inputs, notes
from .derivative import jacobian_of
from .program import Argument, StraightLineProgram, Tape, separated
from .recursion import FrameMotion, body_chain, forward, joint_transforms


@separated
def measurement(
    robot: Robot, gravity: Sequence[Any] = (0, 0, -9.82), frame: int | None = None
) -> StraightLineProgram:
    """y(phi, phi_dot, phi_ddot), shape (n + 6,).

    gravity: [m/s^2] in base axes.
    frame: link whose frame the IMU is fixed to, 1 to the number of links; the last by default.
    """
    frame = len(robot.links) if frame is None else frame
    if not 0 < frame <= len(robot.links):
        raise ValueError(f"frame must be 1 to {len(robot.links)}, got {frame}")
    tape, inputs = Tape(), motor_inputs(robot, "phi", "phi_dot", "phi_ddot")
    chain = body_chain(Robot(robot.links[:frame], convention=robot.convention))
    k = len(chain.segments)
    q = joint_variables(robot, inputs[0].elements)[:k]
    rates, accelerations = (joint_rates(robot, tape, b.elements)[:k] for b in inputs[1:3])
    up: Vector = tuple(-exact(value) for value in gravity)
    motions = forward(tape, joint_transforms(chain, q, tape), rates, accelerations, up)
    last = motions[-1] if motions else FrameMotion(ZERO, ZERO, up)
    lever: Vector = tuple(chain.tool_translation)
    a = added(tape, last.a, lever_acceleration(tape, last.omega, last.alpha, lever))
    R = chain.tool_rotation.T
    y = (*inputs[0].elements, *times(tape, R, last.omega), *times(tape, R, a))
    lines = (
        *notes(robot),
        f"sensor: in the axes of frame {frame}; gravity {tuple(map(str, gravity))} m/s^2",
        "y: motor angles [rad], angular velocity [rad/s], specific force [m/s^2]",
    )
    return tape.program("measurement", inputs, [Argument("y", (len(y),), y)], lines)


def measurement_jacobian(
    robot: Robot, gravity: Sequence[Any] = (0, 0, -9.82), frame: int | None = None
) -> StraightLineProgram:
    """H = dy / d(phi, phi_dot, phi_ddot), shape (n + 6, 3 n), derived from `measurement`."""
    program = jacobian_of(measurement(robot, gravity, frame), ("phi", "phi_dot", "phi_ddot"))
    return replace(program, name="measurement_jacobian")

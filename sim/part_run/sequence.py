"""The motion of a planned part: rest, and for each contour a rapid move, piercing and its cut."""

from collections.abc import Iterator

import numpy as np

from armside.arrays import Array
from armside.kinematics import UnreachableError, inverse_path
from armside.kinematics.rigid import transform
from armside.kinematics.rotation import from_quaternion

from ..laser.setup import Setup
from ..motion.path import Plane
from ..part.chain import Chain, place
from ..part.motion import CutLeg, Leg, PartMotion, on_grid, samples_until
from ..part.plan import Plan, rapid_moves
from ..robot.virtual_robot import LOG_PERIOD
from .rapid import rapid_timing

REST_BEFORE, REST_AFTER = 0.28, 0.35
"""[s], as of a single cut."""


def sequence(setup: Setup, plan: Plan, plane: Plane) -> PartMotion:
    """Motion of the tool, which starts at the lower left corner of the part's box.

    Raises ValueError where the part is out of reach, with the place.
    """
    legs = list(_legs(setup, plan, plane))
    w, x, y, z = setup.tool_pose.quaternion
    a, b = map(float, plan.part.middle)
    return PartMotion(
        legs=tuple(legs),
        plane=plane,
        middle=(a, b),
        tool_quaternion=(w, x, y, z),
        n_samples=samples_until(legs, REST_AFTER, LOG_PERIOD),
        step=LOG_PERIOD,
        rest_before=REST_BEFORE,
    )


def _legs(setup: Setup, plan: Plan, plane: Plane) -> Iterator[Leg]:
    moves, clock = rapid_moves(plan), REST_BEFORE
    placed = plane.to_base(moves - plan.part.middle)
    phi = _motors(setup, placed[:, 0], moves[:, 0])
    cell, speed = setup.cell, plan.cutting.rapid
    for cut, ends, tool, motors in zip(plan.cuts, moves, placed, phi, strict=True):
        timing = rapid_timing(tool, motors, speed, setup.limits, cell.robot, cell.limits)
        if timing is not None:
            yield Leg(path=Chain(ends, np.zeros(1)), timing=timing, start=clock)
            clock = on_grid(clock + timing.duration, LOG_PERIOD)
        clock = on_grid(clock + plan.cutting.pierce, LOG_PERIOD)
        leg = CutLeg(
            path=cut.path,
            timing=cut.profile.timing,
            start=clock,
            name=cut.contour.name,
            kind=cut.contour.kind,
            lead=cut.lead,
            asked_speed=plan.cutting.speed,
        )
        yield leg
        clock = on_grid(leg.end, LOG_PERIOD)


def _motors(setup: Setup, positions: Array, drawn: Array) -> Array:
    """(M, 6) [rad], motor angles at places of the tool, all of one branch."""
    T = transform(from_quaternion(np.array(setup.tool_pose.quaternion)), positions)
    try:
        return inverse_path(setup.cell.robot, T, None, setup.cell.limits)
    except UnreachableError as error:
        where = place(drawn[error.index])
        far = f"{1e3 * error.distance:.1f} mm outside the workspace of {setup.cell.robot.name}"
        raise ValueError(
            f"the part is out of reach at {where}: the wrist would lie {far}"
        ) from error

"""What the controller anticipates of the arm's elasticity: a shift of the programmed path."""

from .model import RobotModel
from .recording import Array
from .servo import interpolate
from .statics import Statics


def anticipated_shift(model: RobotModel, phi: Array, period: float) -> Array:
    """The share of the quasi-static elastic deflection that the reference is to counteract.

    The controller of the robot knows its elasticity with too stiff a model: it expects only
    `Drives.elastic_compensation` of the deflection that gravity and the rigid motion cause.

    Args:
        model: the robot as its controller knows it.
        phi: (N, 6) [rad], motor angles of the programmed path, every `period` [s].

    Returns:
        (N, 3) [m], base axes, to be subtracted from the programmed tool positions.
    """
    _, phi_dot, phi_ddot = interpolate(phi, period, 1)
    statics = Statics(model)
    forces = statics.rigid_forces(phi, phi_dot, phi_ddot)
    return model.drives.elastic_compensation * statics.deflection(phi, forces)

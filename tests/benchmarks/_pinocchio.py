"""Functions of Pinocchio on robots of `kinematics`. It is no dependency."""

# pyright: reportMissingImports=false

from types import SimpleNamespace

import numpy as np

from armside.kinematics import InertialModel, Robot
from armside.kinematics.rigid import link_transform
from armside.scripts.thesis.peers import pinocchio_model


def pinocchio_dynamics(model: InertialModel) -> SimpleNamespace:
    """mass_matrix(q) and inverse_dynamics(q, v, a) of a model without motors, standard convention.

    The mass matrix is handed over as Pinocchio makes it: its upper triangle is filled.
    """
    import pinocchio as pin

    pinocchio, _ = pinocchio_model(model.robot)
    joint, placement = 0, pin.SE3.Identity()
    for link, body in zip(model.robot.links, model.bodies, strict=True):
        if link.moves:
            joint, placement = joint + 1, pin.SE3.Identity()
        placement = placement * pin.SE3(link_transform(link))
        xx, yy, zz, xy, xz, yz = body.inertia
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=float)
        inertia = pin.Inertia(body.mass, np.array(body.com, dtype=float), tensor)
        pinocchio.appendBodyToJoint(joint, inertia, placement)
    pinocchio.gravity.linear = np.array(model.gravity, dtype=float)
    data, crba, rnea = pinocchio.createData(), pin.crba, pin.rnea
    return SimpleNamespace(
        mass_matrix=lambda q: crba(pinocchio, data, q),
        inverse_dynamics=lambda q, v, a: rnea(pinocchio, data, q, v, a),
    )


def pinocchio_functions(robot: Robot) -> SimpleNamespace:
    """pose(q), jacobian(q), acceleration(q, v, a): the fastest calls to a NumPy array."""
    model, tool = pinocchio_model(robot)
    import pinocchio as pin

    data = model.createData()
    placement, axes = data.oMf[tool], pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    place, differentiate = pin.framesForwardKinematics, pin.computeFrameJacobian
    move, accelerate = pin.forwardKinematics, pin.getFrameClassicalAcceleration

    def pose(q: np.ndarray) -> np.ndarray:
        place(model, data, q)
        return placement.np

    def jacobian(q: np.ndarray) -> np.ndarray:
        return differentiate(model, data, q, tool, axes)

    def acceleration(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        move(model, data, q, v, a)
        return accelerate(model, data, tool, axes).vector

    return SimpleNamespace(pose=pose, jacobian=jacobian, acceleration=acceleration)

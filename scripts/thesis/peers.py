"""Robots of `kinematics` in other libraries, for benchmarks. None of them is a dependency."""

# pyright: reportMissingImports=false

from types import SimpleNamespace
from typing import Any

import numpy as np

from armside.kinematics import Convention, InertialModel, Joint, Limits, Robot
from armside.kinematics.rigid import link_transform, standard_links


def pinocchio_model(robot: Robot) -> tuple[Any, int]:
    """A Pinocchio model of a D-H robot, and its tool frame. It moves by joint variables, not phi.

    Raises ImportError where Pinocchio (`pip install pin`) is not installed.
    """
    import pinocchio as pin

    model = pin.Model()
    parent, placement = 0, pin.SE3.Identity()
    for number, link in enumerate(standard_links(robot)):
        if link.moves:
            kind = pin.JointModelRZ() if link.joint is Joint.REVOLUTE else pin.JointModelPZ()
            parent = model.addJoint(parent, kind, placement, f"joint_{number}")
            placement = pin.SE3.Identity()
        placement = placement * pin.SE3(link_transform(link))
    tool = pin.Frame("tool0", parent, 0, placement, pin.FrameType.OP_FRAME)
    return model, model.addFrame(tool)


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


def toolbox_robot(robot: Robot, limits: Limits | None = None) -> Any:
    """A D-H robot of the Robotics Toolbox for Python; its configuration is the joint variables.

    limits: lower and upper ends of all joints, for its inverse kinematics.

    Raises ImportError where it (`pip install roboticstoolbox-python`) is not installed.
    """
    import roboticstoolbox as rtb

    modified, links = robot.convention is Convention.MODIFIED, []
    ends = zip(limits.lower, limits.upper, strict=True) if limits else None
    for link in robot.links:
        theta, d, a, alpha = map(float, (link.theta, link.d, link.a, link.alpha))
        given: dict[str, Any] = {"qlim": list(next(ends))} if ends else {}
        if link.joint is Joint.PRISMATIC:
            kind, given["offset"], given["theta"] = "Prismatic", d, theta
        else:
            kind, given["offset"], given["d"] = "Revolute", theta, d
        build = getattr(rtb, f"{kind}{'MDH' if modified else 'DH'}")
        links.append(build(a=a, alpha=alpha, **given))
    return rtb.DHRobot(links)

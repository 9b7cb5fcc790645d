"""Robots of `kinematics` in other libraries, to compare with. None of them is a dependency."""

# pyright: reportMissingImports=false

from typing import Any

from armside.kinematics import Convention, Joint, Limits, Robot
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

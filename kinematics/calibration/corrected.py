"""The calibrated robot as Denavit-Hartenberg data, for export and for every other tool."""

from math import pi

from armside.arrays import Array

from ..dh import Joint, Link, Robot
from ..links import standard_links
from .error_model import DH, ErrorModel


def corrected(model: ErrorModel, errors: Array) -> Robot:
    """The robot with its link errors (E,) put into its table; beta_i becomes two constant links."""
    value = dict(zip(model.names, errors.tolist(), strict=True))
    links: list[Link] = []
    for i, link in enumerate(standard_links(model.robot), 1):
        numbers = {name: float(getattr(link, name)) + value[f"{name}_{i}"] for name in DH}
        links.append(Link(**numbers, joint=link.joint))
        if beta := value[f"beta_{i}"]:
            # Rot_y(beta) = Rot_z(pi/2) Rot_x(beta) Rot_z(-pi/2)
            links.append(Link(theta=pi / 2, alpha=beta, joint=Joint.FIXED))
            links.append(Link(theta=-pi / 2, joint=Joint.FIXED))
    robot = model.robot
    return Robot(links, robot.coupling, robot.offset, name=f"{robot.name} calibrated")

"""Inertial elements of a URDF file, each checked on its own."""

from xml.etree.ElementTree import Element

from ..equations.inertial_model import Body
from .elements import Inertial
from .values import attribute, number, transform


def inertial_of(where: str, element: Element | None) -> Inertial | None:
    """Mass properties of a link, None where it has none, or zeros. ValueError names the link."""
    if element is None:
        return None
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = [attribute(element, "inertia", name) or 0.0 for name in names]
    inertia = [number(f"{where}: {n}", v) for n, v in zip(names, values, strict=True)]
    mass = number(f"{where}: mass", attribute(element, "mass", "value"))
    if mass == 0 and not any(inertia):
        return None
    if mass <= 0:
        raise ValueError(f"{where}: mass must be > 0 kg, got {mass:g}")
    try:
        body = Body(mass=mass, inertia=(*inertia,))  # pyright: ignore[reportArgumentType]
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    return Inertial(transform(where, element), body)

"""Tasks of robots whose corrections may be exchanged: those that follow the same path."""

from armside.ilc.workbench.words import Words

from ..cutting.options import LaserCfg
from ..shell.errors import InputError
from .controllers import laser_values

CONTOUR = ("shape", "radius", "size", "width", "corner", "contour")
PLACE = ("pose", "plane", "position", "quaternion")
"""Of one robot; another robot has poses of its own."""


def refuse_other_path(before: str, now: str) -> None:
    """Raise InputError where two plants, such as large:radius=2,speed=60, follow other paths."""
    old, new = (Words.parse(text) for text in (before, now))
    known, asked = (LaserCfg(robot=words.name, **laser_values(words)) for words in (old, new))
    names = (*CONTOUR, *(PLACE if old.name == new.name else ()))
    for name in names:
        if getattr(known, name) != getattr(asked, name):
            other = f"{now} has another {name}, and a correction belongs to its path"
            raise InputError(f"{before} cannot be started from: {other}")

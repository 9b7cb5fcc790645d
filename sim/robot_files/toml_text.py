"""Numbers and tables as text of TOML."""

import json
from collections.abc import Iterable, Iterator, Sequence
from math import gcd, pi

from armside.kinematics import Joint, Limits, Link, Robot


def _fractions_of_pi() -> Iterator[tuple[float, str]]:
    for d in (1, 2, 3, 4, 6):
        for n in range(-4 * d, 4 * d + 1):
            if n and gcd(n, d) == 1:
                factor = {1: "", -1: "-"}.get(n, f"{n}*")
                yield n * pi / d, f'"{factor}pi"' if d == 1 else f'"{factor}pi/{d}"'


_PI = tuple(_fractions_of_pi())
_ROUNDING = 1e-14


def number(value: float) -> str:
    """A number; a fraction of pi as text, such as "-pi/2"."""
    value = float(value) + 0.0
    for exact, shown in _PI:
        if abs(value - exact) < _ROUNDING:
            return shown
    return repr(int(value)) if value == int(value) and abs(value) < 1e9 else repr(value)


def row(values: Iterable[float]) -> str:
    """A list of numbers."""
    return f"[{', '.join(number(value) for value in values)}]"


def text(value: str) -> str:
    """A string in quotes."""
    return json.dumps(value, ensure_ascii=False)


def kinematics_of(robot: Robot) -> list[str]:
    """Lines of name, convention, offset and coupling, where they are not the defaults."""
    lines = [f"name = {text(robot.name)}"]
    if robot.convention.value != "standard":
        lines.append(f'convention = "{robot.convention.value}"')
    if robot.offset.any():
        lines.append(f"offset = {row(robot.offset.tolist())}")
    rows = robot.coupling.tolist()
    if any(v != float(i == j) for i, r in enumerate(rows) for j, v in enumerate(r)):
        lines += ["coupling = [", *(f"  {row(r)}," for r in rows), "]"]
    return lines


def links_of(name: str, links: Sequence[Link]) -> list[str]:
    """Lines of the tables of a D-H table; numbers that are 0 are left out."""
    lines = list[str]()
    for link in links:
        lines += ["", f"[[{name}]]"]
        for field in ("theta", "d", "a", "alpha"):
            if float(getattr(link, field)):
                lines.append(f"{field} = {number(float(getattr(link, field)))}")
        if link.joint is not Joint.REVOLUTE:
            lines.append(f'joint = "{link.joint.value}"')
    return lines


def limits_of(limits: Limits) -> list[str]:
    """Lines of the table of limits."""
    lines = ["", "[limits] # [rad] and [rad/s]; [m] and [m/s] of a prismatic axis"]
    lines += [f"{name} = {row(getattr(limits, name))}" for name in ("lower", "upper", "speed")]
    for bound in limits.coupled:
        lines += ["", "[[limits.coupled]]", f"coefficients = {row(bound.coefficients)}"]
        lines += [f"lower = {number(bound.lower)}", f"upper = {number(bound.upper)}"]
    return lines

"""Robot files: the Denavit-Hartenberg table of a serial arm in TOML, read and written.

    name = "my arm"
    convention = "standard"              # or "modified" [default: standard]
    offset = [0, "-pi/2", 0]             # joint variables at phi = 0 [rad or m; default 0]
    coupling = [[1, 0, 0], [0, 1, 0], [0, -1, 1]]       # thesis (4.10) [default: identity]

    [[link]]                             # one table for each row, from the base
    theta = 0                            # [rad; default 0]
    d = 0.475                            # [m; default 0]
    a = 0.15                             # [m; default 0]
    alpha = "-pi/2"                      # [rad; default 0]
    joint = "revolute"                   # or "prismatic" or "fixed" [default: revolute]

    [limits]                             # one number for each motor
    lower = [-2.9, -1.2, -1.1]           # [rad or m]
    upper = [2.9, 1.2, 1.2]              # [rad or m]
    speed = [2.1, 2.1, 2.1]              # [rad/s or m/s]

    [[limits.coupled]]                   # ranges of sums of motor angles; as many as there are
    coefficients = [0, -1, 1]
    lower = -1.2                         # [rad]
    upper = 1.2

    [[gear_error]]                       # transmission error of a gear, any number of terms
    joint = 1                            # motor, from 1
    order = 240                          # periods per turn of the output
    amplitude = 1.2e-4                   # [rad], arm side
    phase = 2.6                          # [rad]

Numbers may be text with pi, such as "-pi/2". A gear's output minus its motor angle is the sum of
its terms amplitude sin(order phi + phase).

A gear-error file has the transmission error found in the gears of one arm:

    version = 1
    robot = "LARGE_ROBOT"                # name of the robot, as its robot file has it
    motors = 6                           # number of motors

    [[gear_error]]                       # any number of terms, as above, amplitude at most 0.01 rad
    joint = 1
    order = 220.0
    amplitude = 1.1e-5
    phase = 5.3
    order_deviation = 0.1                # standard deviations, for information [optional]
    amplitude_deviation = 5e-7
    phase_deviation = 0.05
"""

import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from .dh import Convention, CoupledRange, Joint, Limits, Link, Robot, check_unit

if TYPE_CHECKING:
    from .urdf import UrdfArm

LARGEST = 1_000_000
"""Bytes of a robot file; a table of joints needs a few thousand."""
KEYS = ("name", "convention", "offset", "coupling", "link", "limits")
"""Keys of kinematics in a robot file."""
OF_CELL = (
    *("model", "urdf", "orientation", "home", "imu", "pose", "program", "learning", "hardware"),
    *("base", "body", "drives", "gears", "structure", "effects", "tool"),
)
"""Keys of a robot file beside them: `armside.sim.robot_file` reads all but the URDF."""
_LINK = ("theta", "d", "a", "alpha", "joint")
_LIMITS = ("lower", "upper", "speed")
_COUPLED = ("coefficients", "lower", "upper")


Content = TypeVar("Content")


class GearTerm(NamedTuple):
    """One period of a gear's transmission error: amplitude sin(order phi + phase), output minus
    motor angle."""

    joint: int
    """From 1."""
    order: float
    """Periods per turn of the output."""
    amplitude: float
    phase: float
    """[rad], arm side."""


class Arm(NamedTuple):
    """A robot and the ranges of its motors."""

    robot: Robot
    limits: Limits


def read_robot(file: Path) -> Arm:
    """Robot of a file; without limits, revolute joints turn by 180 degrees to either side.

    Tables of hardware and poses are passed over; of a URDF that it names the robot is that.

    Raises:
        ValueError: the file is not as described above; the message names file and field.
        OSError: the file cannot be read.
    """
    return read_toml(file, lambda data: _arm_and_gears(data, file.parent))[0]


def read_gear_error(file: Path) -> tuple[GearTerm, ...]:
    """Transmission error of a robot file, none where it states none. Raises as `read_robot`."""
    return read_toml(file, lambda data: _arm_and_gears(data, file.parent))[1]


def _arm_and_gears(data: Mapping[str, Any], folder: Path) -> tuple[Arm, tuple[GearTerm, ...]]:
    refuse_unknown("the file", data, (*KEYS, "gear_error", *OF_CELL))
    arm, _ = arm_in(data, folder)
    rows = enumerate(_tables("gear_error", data.get("gear_error", []), "gear_error"), 1)
    return arm, tuple(gear_term(f"gear_error {k}", arm.robot, row) for k, row in rows)


def arm_in(data: Mapping[str, Any], folder: Path) -> tuple[Arm, "UrdfArm | None"]:
    """Robot of the D-H table, or of the URDF that the key `urdf` names, beside that.

    Limits that stand beside a URDF are taken in place of its own. Raises as `arm_of`.
    """
    own = {name: data[name] for name in KEYS if name in data}
    if "urdf" not in data:
        return arm_of(own), None
    if given := [name for name in own if name not in ("name", "limits")]:
        raise ValueError(f"urdf has the kinematics: leave out {', '.join(given)}")
    from .urdf import read_urdf

    file, _, links = str(data["urdf"]).partition("#")
    base, _, tip = links.rpartition(":")
    tree = read_urdf(beside(folder, "urdf", file), base or None, tip or None)
    robot = replace(tree.robot, name=data.get("name", tree.robot.name))
    return Arm(robot, _limits(robot, own.get("limits", {}), tree.limits)), tree


def beside(folder: Path, name: str, given: Any) -> Path:
    """A file that a robot file in a folder names. Raises ValueError with the name of the field."""
    if not isinstance(given, str) or not given:
        raise ValueError(f"{name} must be the name of a file, got {given!r}")
    file = folder / given
    if not file.is_file():
        raise ValueError(f"{name} must be a file, there is no {file}")
    return file


def read_toml(file: Path, made: Callable[[Mapping[str, Any]], Content]) -> Content:
    """What is made of the tables of a TOML file.

    Raises OSError, or ValueError that begins with the name of the file: it is too large or no TOML,
    or `made` refuses it.
    """
    if file.exists() and not file.is_file():
        raise ValueError(f"{file} is no regular file")
    with file.open("rb") as content:
        text = content.read(LARGEST + 1)
    if len(text) > LARGEST:
        raise ValueError(f"{file.name}: a robot file has at most {LARGEST} bytes")
    try:
        return made(toml_of(text))
    except (ValueError, TypeError, RecursionError) as error:
        raise ValueError(f"{file.name}: {' '.join(str(error).split())}") from error


def toml_of(content: bytes) -> dict[str, Any]:
    """Tables of the content of a TOML file, with or without the byte order mark that editors on
    Windows write. Raises ValueError where it is no UTF-8 or no TOML."""
    return tomllib.loads(content.decode("utf-8-sig"))


def arm_of(data: Mapping[str, Any]) -> Arm:
    """Robot of the tables of a file. Raises ValueError or TypeError with the name of the field."""
    refuse_unknown("the file", data, KEYS)
    links = links_of("link", data.get("link"))
    name, coupling, offset = data.get("name", "robot"), data.get("coupling"), data.get("offset")
    if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 80):
        raise ValueError(f"name must be printable text of 1 to 80 characters, got {name!r}")
    if coupling is not None:
        if not isinstance(coupling, list):
            raise ValueError(f"coupling must be a list of rows, got {coupling!r}")
        coupling = [numbers("coupling", row) for row in coupling]
    if offset is not None:
        offset = numbers("offset", offset)
        for axis, value in enumerate(offset, 1):
            check_unit(f"offset of axis {axis}", "theta", value)
    convention = _choice("convention", data.get("convention", "standard"), Convention)
    robot = Robot(links, coupling, offset, convention, name)
    if not robot.n_joints:
        raise ValueError("needs at least one link that is not fixed")
    return Arm(robot, _limits(robot, data.get("limits", {})))


def links_of(name: str, rows: Any) -> list[Link]:
    """Links of the tables [[name]]. Raises ValueError; the message names table and field."""
    if not isinstance(rows, list) or not rows:
        raise ValueError(f"needs at least one [[{name}]]")
    links = list[Link]()
    for number, row in enumerate(rows, 1):
        where = f"{name} {number}"
        if not isinstance(row, dict):
            raise ValueError(f"{where} must be a table [[link]]")
        refuse_unknown(where, row, _LINK)
        own = {key: _number(f"{where}: {key}", row[key]) for key in _LINK[:4] if key in row}
        for key, value in own.items():
            check_unit(f"{where}: {key}", key, value)
        joint = _choice(f"{where}: joint", row.get("joint", "revolute"), Joint)
        links.append(Link(**own, joint=joint))
    return links


def _limits(robot: Robot, data: Any, default: Limits | None = None) -> Limits:
    if not isinstance(data, dict):
        raise ValueError("limits must be a table [limits]")
    refuse_unknown("limits", data, (*_LIMITS, "coupled"))
    n, values = robot.n_joints, {}
    for name, usual in zip(_LIMITS, (-pi, pi, pi), strict=True):
        own = [usual] * n if default is None else list(getattr(default, name))
        values[name] = tuple(numbers(f"limits: {name}", data.get(name, own)))
        if len(values[name]) != n:
            raise ValueError(f"limits: {name} must have {n} numbers, got {len(values[name])}")
    for name in _LIMITS[:2]:
        for axis, (slides, end) in enumerate(zip(robot.slides, values[name], strict=True), 1):
            check_unit(f"limits: {name} of axis {axis}", "slide" if slides else "range", end)
    try:
        return Limits(**values, coupled=_coupled(data.get("coupled", [])))
    except ValueError as error:
        raise ValueError(f"limits: {error}") from error


def _tables(name: str, rows: Any, key: str) -> list[dict[str, Any]]:
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise ValueError(f"{name} must be tables [[{key}]]")
    return rows


def gear_term(where: str, robot: Robot, row: Mapping[str, Any]) -> GearTerm:
    """A term of a table [[gear_error]]. Raises ValueError; the message names table and field."""
    refuse_unknown(where, row, GearTerm._fields)
    if missing := [name for name in GearTerm._fields if name not in row]:
        raise ValueError(f"{where} lacks {missing[0]}")
    joint = row["joint"]
    if isinstance(joint, bool) or not isinstance(joint, int) or not 1 <= joint <= robot.n_joints:
        raise ValueError(f"{where}: joint must be 1 to {robot.n_joints}, got {joint!r}")
    return GearTerm(joint, *(_number(f"{where}: {n}", row[n]) for n in GearTerm._fields[1:]))


def _coupled(rows: Any) -> tuple[CoupledRange, ...]:
    found = list[CoupledRange]()
    for number, row in enumerate(_tables("limits: coupled", rows, "limits.coupled"), 1):
        where = f"limits: coupled {number}"
        refuse_unknown(where, row, _COUPLED)
        if missing := [name for name in _COUPLED if name not in row]:
            raise ValueError(f"{where} lacks {', '.join(missing)}")
        ends = {name: _number(f"{where}: {name}", row[name]) for name in _COUPLED[1:]}
        factors = numbers(f"{where}: coefficients", row["coefficients"])
        found.append(CoupledRange(coefficients=tuple(factors), **ends))
    return tuple(found)


def numbers(name: str, values: Any) -> list[float]:
    """A list of numbers, or of text such as -pi/2. Raises ValueError with the name."""
    if not isinstance(values, list):
        raise ValueError(f"{name} must be a list of numbers, got {values!r}")
    return [_number(name, value) for value in values]


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError(f"{name} must be a number, got {value!r}")
    if isinstance(value, str):
        from .expressions.grammar import parse

        try:
            value = float(parse(value))
        except (ValueError, TypeError):
            wanted = f"a number or text such as '-pi/2', got {value!r}"
            raise ValueError(f"{name} must be {wanted}") from None
    if not abs(value) < 1e6:
        raise ValueError(f"{name} must be a number below 1e6, got {value}")
    return float(value)


def _choice(name: str, value: Any, kind: Any) -> Any:
    try:
        return kind(value)
    except ValueError:
        allowed = ", ".join(member.value for member in kind)
        raise ValueError(f"{name} must be one of {allowed}, got {value!r}") from None


def refuse_unknown(where: str, given: Mapping[str, Any], allowed: Sequence[str]) -> None:
    """Raise ValueError for a key that is not allowed."""
    if unknown := sorted(set(given) - set(allowed)):
        raise ValueError(f"{where} has the unknown key {unknown[0]!r}; keys: {', '.join(allowed)}")


def robot_tables(
    robot: Robot, limits: Limits, shown: Callable[[float], float | str] = float
) -> dict[str, Any]:
    """Tables of the file of a robot of numbers, without defaults; `shown` is each number in it."""
    found: dict[str, Any] = {"name": robot.name}
    if robot.convention is not Convention.STANDARD:
        found["convention"] = robot.convention.value
    if robot.offset.any():
        found["offset"] = [*map(shown, robot.offset.tolist())]
    if (robot.coupling != np.eye(robot.n_joints)).any():
        found["coupling"] = [[*map(shown, row)] for row in robot.coupling.tolist()]
    ends = {name: [*map(shown, getattr(limits, name))] for name in _LIMITS}
    sums = [
        {"coefficients": [*map(shown, bound.coefficients)]}
        | {name: shown(getattr(bound, name)) for name in _COUPLED[1:]}
        for bound in limits.coupled
    ]
    found["link"] = link_tables(robot.links, shown)
    found["limits"] = ends | ({"coupled": sums} if sums else {})
    return found


def link_tables(
    links: Iterable[Link], shown: Callable[[float], float | str] = float
) -> list[dict[str, Any]]:
    """Tables [[link]], without the numbers that are 0."""
    tables = list[dict[str, Any]]()
    for link in links:
        given = {name: float(getattr(link, name)) for name in _LINK[:4]}
        tables.append({name: shown(value) for name, value in given.items() if value})
        if link.joint is not Joint.REVOLUTE:
            tables[-1]["joint"] = link.joint.value
    return tables


def robot_toml(robot: Robot, limits: Limits, gear_error: Sequence[GearTerm] = ()) -> str:
    """Text of the file of a robot of numbers; `read_robot` reads the same robot back."""
    import tomlkit  # takes a tenth of a second, and few write a file

    terms = {"gear_error": [term._asdict() for term in gear_error]} if gear_error else {}
    return tomlkit.dumps(robot_tables(robot, limits) | terms)


VERSION = 1
LARGEST_ORDER, LARGEST_AMPLITUDE = 1e4, 0.01
"""Periods per turn, and [rad]: beyond them it is no gear's error."""
DEVIATIONS = ("order_deviation", "amplitude_deviation", "phase_deviation")
_KEYS = ("version", "robot", "motors", "gear_error")


def read_gear_file(file: Path, robot: Robot) -> tuple[GearTerm, ...]:
    """Terms of a gear-error file of this robot. Raises as `read_robot`, also for another robot."""
    return read_toml(file, lambda data: _terms(data, robot))


def gear_toml(
    robot: Robot, terms: Sequence[GearTerm], deviations: Sequence[tuple[float, float, float]]
) -> str:
    """Text of a file. deviations: of order, amplitude and phase of each term."""
    import tomlkit

    rows = list[dict[str, float]]()
    for term, own in zip(terms, deviations, strict=True):
        finite = zip(DEVIATIONS, own, strict=True)
        rows.append(term._asdict() | {name: dev for name, dev in finite if dev < LARGEST_ORDER})
    head = {"version": VERSION, "robot": robot.name, "motors": robot.n_joints}
    return tomlkit.dumps(head | {"gear_error": rows})


def _terms(data: Mapping[str, Any], robot: Robot) -> tuple[GearTerm, ...]:
    if "version" not in data or "gear_error" not in data:
        raise ValueError("is no gear-error file: it needs version and [[gear_error]]")
    if data["version"] != VERSION:
        raise ValueError(f"version must be {VERSION}, got {data['version']!r}")
    refuse_unknown("the file", data, _KEYS)
    if (name := data.get("robot")) != robot.name:
        raise ValueError(f"is of robot {name!r}, not of {robot.name!r}")
    if (motors := data.get("motors")) != robot.n_joints:
        raise ValueError(f"motors must be {robot.n_joints}, got {motors!r}")
    terms = list[GearTerm]()
    for number, row in enumerate(_tables("gear_error", data["gear_error"], "gear_error"), 1):
        where = f"gear_error {number}"
        refuse_unknown(where, row, (*GearTerm._fields, *DEVIATIONS))
        own = {name: value for name, value in row.items() if name not in DEVIATIONS}
        terms.append(gear_term(where, robot, own))
        for name, most in (("order", LARGEST_ORDER), ("amplitude", LARGEST_AMPLITUDE)):
            if abs(value := getattr(terms[-1], name)) > most:
                raise ValueError(f"{where}: {name} must be at most {most:g}, got {value:g}")
    return tuple(terms)

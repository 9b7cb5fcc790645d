"""`armside verify urdf`: URDF in and out beside Pinocchio's reading of the same files.

Out: the robots of this project, exported with the masses of their hardware. In: files that others
wrote, from those of `urdf_arms.PACKAGES` that are installed.
"""

import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside import assets
from armside.arrays import Array
from armside.kinematics import CATALOGUE, UrdfArm, read_urdf
from armside.kinematics.codegen.languages import interpreted
from armside.kinematics.codegen.robot_xml import urdf as urdf_text
from armside.kinematics.equations import dynamics, forward_kinematics
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.robot_file.find import is_cell_file, load_robot

from ..shell.errors import needs
from .urdf_arms import LEAST_JOINTS, ForeignFile, foreign_files, longest_chain
from .urdf_pinocchio import PinocchioChain

LARGEST = 1e-9
"""Greatest difference of poses [m], Jacobians [m, -] and mass matrices, these relative to their
greatest element where it is above 1 kg m^2."""
FOREIGN_ARMS = 20
"""Files of others that must be read, at least."""
COLUMNS = ("source", "file", "tip", "joints", "verdict", "pose", "Jacobian", "mass matrix")
Row = tuple[Any, ...]


def urdf(seeds: Iterable[int]) -> Table:
    """Greatest differences over one random configuration for each seed."""
    with needs("peers", "armside verify urdf", "Pinocchio"):
        import pinocchio  # noqa: F401  # pyright: ignore[reportMissingImports]
    numbers = list(seeds)
    rows = [*(shipped(name, numbers) for name in shipped_robots()), *foreign(numbers)]
    read = [row for row in rows if row[0] != "armside" and row[4] == "agrees"]
    errors = [value for row in rows for value in row[5:] if isinstance(value, float)]
    differ = [row for row in rows if row[4] == "DIFFERS"]
    return Table(
        f"URDF in and out beside Pinocchio at {len(numbers)} random configurations",
        COLUMNS,
        rows,
        (
            all_hold(f"no difference is above {LARGEST:g}", np.array(errors) <= LARGEST),
            all_hold("every robot of this project is read by Pinocchio", _ours_agree(rows)),
            all_hold("no file of others is read otherwise in silence", [not differ]),
            _many(len(read)),
        ),
    )


def _many(count: int) -> Check:
    statement = f"{count} files of others are read alike, at least {FOREIGN_ARMS}"
    return Check("", statement, "", count, low=FOREIGN_ARMS)


def shipped_robots() -> list[str]:
    """Names and robot files of this project."""
    folder = Path(assets.LARGE_ROBOT_XML).parent
    return [*CATALOGUE, *filter(is_cell_file, map(str, sorted(folder.glob("*.toml"))))]


def shipped(name: str, seeds: Sequence[int]) -> Row:
    """Row of a robot of this project, whose exported file Pinocchio reads."""
    heavy = load_robot(name, masses=True)
    robot, limits = heavy.arm
    joints = tuple(f"joint_{i}" for i in range(1, robot.n_joints + 1))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.urdf"
        file.write_text(urdf_text(robot, limits, heavy.bodies), encoding="utf-8")
        theirs = PinocchioChain(file, joints, "tool0")
    own = UrdfArm(robot, limits, joints, heavy.bodies or None)
    errors = _errors(own, theirs, seeds)
    return "armside", Path(name).name, "tool0", robot.n_joints, _verdict(errors), *errors


def foreign(seeds: Sequence[int]) -> list[Row]:
    """Rows of the arms in files of others; files without an arm have none."""
    rows = list[Row]()
    for file in foreign_files():
        try:
            tip, count = longest_chain(file.path)
        except ValueError as error:
            rows.append(_refused(file, "-", "-", error))
            continue
        if count >= LEAST_JOINTS:
            rows.append(_foreign(file, tip, count, seeds))
    return rows


def _foreign(file: ForeignFile, tip: str, count: int, seeds: Sequence[int]) -> Row:
    try:
        arm = read_urdf(file.path, tip=tip)
    except ValueError as error:
        return _refused(file, tip, count, error)
    try:
        theirs = PinocchioChain(file.path, arm.joints, tip)
    except ValueError as error:
        verdict = f"Pinocchio: {_line(error)}"
        return file.package, file.name, tip, len(arm.joints), verdict, "-", "-", "-"
    errors = _errors(arm, theirs, seeds)
    return file.package, file.name, tip, len(arm.joints), _verdict(errors), *errors


def _errors(arm: UrdfArm, theirs: PinocchioChain, seeds: Sequence[int]) -> tuple[Any, Any, Any]:
    """Greatest differences of pose, Jacobian and mass matrix; "-" for an arm without masses."""
    robot, M = arm.robot, arm.robot.coupling
    pose, jacobian = (
        interpreted(program(robot))
        for program in (forward_kinematics.pose, forward_kinematics.jacobian)
    )
    weighs = arm.bodies is not None
    mass = interpreted(dynamics.mass_matrix(arm.inertial_model())) if weighs else None
    found = []
    for seed in seeds:
        phi = np.random.default_rng(seed).uniform(-1, 1, robot.n_joints)
        T, J, D = theirs.at(M @ phi)
        of_mass = _relative(mass(phi), M.T @ D @ M) if mass else 0.0
        found.append((_largest(pose(phi) - T), _largest(jacobian(phi) - J @ M), of_mass))
    of_pose, of_jacobian, of_mass = (float(value) for value in np.max(found, axis=0))
    return of_pose, of_jacobian, of_mass if mass else "-"


def _largest(difference: Array) -> float:
    return float(np.abs(difference).max())


def _relative(ours: Array, theirs: Array) -> float:
    return _largest(ours - theirs) / max(1.0, _largest(theirs))


def _verdict(errors: Sequence[Any]) -> str:
    agree = all(value <= LARGEST for value in errors if isinstance(value, float))
    return "agrees" if agree else "DIFFERS"


def _refused(file: ForeignFile, tip: str, count: Any, error: ValueError) -> Row:
    return file.package, file.name, tip, count, f"refused: {_line(error)}", "-", "-", "-"


def _line(error: ValueError) -> str:
    """One line of a message that fits into a table."""
    text = " ".join(str(error).split()).replace("|", "/")
    text = text.partition(": ")[2] if text.split(":")[0].endswith(".urdf") else text
    return text if len(text) <= 120 else f"{text[:117]}..."


def _ours_agree(rows: Sequence[Row]) -> list[bool]:
    return [row[4] == "agrees" for row in rows if row[0] == "armside"]

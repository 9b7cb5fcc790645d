"""URDF in and out beside Pinocchio's reading of the same files.

Out: the robots of this project, exported with the masses of their hardware. In: files that others
wrote, from those of `_urdf_files.PACKAGES` that are installed. Greatest differences over one random
configuration for each seed.
"""

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside import assets
from armside.arrays import Array
from armside.kinematics import CATALOGUE, read_urdf
from armside.kinematics.codegen.languages import interpreted
from armside.kinematics.codegen.robot_xml import urdf as urdf_text
from armside.kinematics.equations import dynamics, forward_kinematics
from armside.kinematics.urdf import UrdfArm
from armside.sim.robot_file.find import is_cell_file, load_robot

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_once
from ._urdf_files import LEAST_JOINTS, ForeignFile, PinocchioChain, foreign_files, longest_chain

LARGEST = 1e-9
"""Greatest difference of poses [m], Jacobians [m, -] and mass matrices, these relative to their
greatest element where it is above 1 kg m^2."""
FOREIGN_ARMS = 20
"""Files of others that must be read, at least."""
OURS = "armside"
ERRORS = ("pose", "Jacobian", "mass matrix")


def run(seeds: tuple[int, ...], _: Tally) -> Iterator[Row]:
    yield from (shipped(name, seeds) for name in shipped_robots())
    yield from foreign(seeds)


def checks(rows: Rows) -> Iterator[Check]:
    errors = [row[name] for row in rows for name in ERRORS if isinstance(row[name], float)]
    yield all_hold(f"no difference is above {LARGEST:g}", np.array(errors) <= LARGEST)
    of_ours, agree = rows["source"] == OURS, rows["verdict"] == "agrees"
    yield all_hold("every robot of this project is read by Pinocchio", agree[of_ours])
    silence = "no file of others is read otherwise in silence"
    yield all_hold(silence, rows["verdict"] != "DIFFERS")
    count = int((agree & ~of_ours).sum())
    statement = f"{count} files of others are read alike, at least {FOREIGN_ARMS}"
    yield Check("", statement, "", count, low=FOREIGN_ARMS)


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
    return _row(OURS, Path(name).name, "tool0", robot.n_joints, _verdict(errors), errors)


def foreign(seeds: Sequence[int]) -> Iterator[Row]:
    """Rows of the arms in files of others; files without an arm have none."""
    for file in foreign_files():
        try:
            tip, count = longest_chain(file.path)
        except ValueError as error:
            yield _row(file.package, file.name, "-", "-", f"refused: {_line(error)}")
            continue
        if count >= LEAST_JOINTS:
            yield _foreign(file, tip, count, seeds)


def _foreign(file: ForeignFile, tip: str, count: int, seeds: Sequence[int]) -> Row:
    where = file.package, file.name, tip
    try:
        arm = read_urdf(file.path, tip=tip)
    except ValueError as error:
        return _row(*where, count, f"refused: {_line(error)}")
    try:
        theirs = PinocchioChain(file.path, arm.joints, tip)
    except ValueError as error:
        return _row(*where, len(arm.joints), f"Pinocchio: {_line(error)}")
    errors = _errors(arm, theirs, seeds)
    return _row(*where, len(arm.joints), _verdict(errors), errors)


def _row(
    source: str, file: str, tip: str, joints: Any, verdict: str, errors: Sequence[Any] = "---"
) -> Row:
    cells = {"source": source, "file": file, "tip": tip, "joints": joints, "verdict": verdict}
    return cells | dict(zip(ERRORS, errors, strict=True))


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


def _line(error: ValueError) -> str:
    """One line of a message that fits into a table."""
    text = " ".join(str(error).split()).replace("|", "/")
    text = text.partition(": ")[2] if text.split(":")[0].endswith(".urdf") else text
    return text if len(text) <= 120 else f"{text[:117]}..."


CLAIM = Claim(
    title="URDF in and out beside Pinocchio at {n} random configurations",
    seeds=5,
    cases=at_once,
    run=run,
    checks=checks,
    processes=1,
)

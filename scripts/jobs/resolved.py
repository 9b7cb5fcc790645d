"""Resolved options of `armside laser`: those of a row in a dataset, and the key that they hash to.

Options that mean the same run have the same key, whichever way they were written; a file with
another content is another configuration, wherever it is.
"""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import mujoco

from armside.kinematics.robot_file import read_toml
from armside.sim.cell import CELLS, ToolPose
from armside.sim.records.files import check_file
from armside.sim.records.summary import plain
from armside.sim.robot.effects import Effect, available
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot.mjcf import ModelError, scalar
from armside.sim.robot.model import load_model
from armside.sim.robot_file.find import find_cell, read_cell

from ..cutting.options import LaserCfg
from ..cutting.specification import MM, cut, dimensions, tool_pose
from ..shell.errors import InputError, one_line
from .store import digest_of

FILES = ("contour", "model", "identification", "individual", "twin", "gears")
"""Options that name a file or a folder of files, or may."""
Content = Callable[[str, Path], str]
"""Hash of the content of an option's file."""
REMEMBERED = 4096
"""Configurations, most of a grid's between its check and its points; each takes 3 kB."""


def content_of(name: str, path: Path) -> str:
    """Hash of the content of an option's file, and of the files that a model includes. Raises
    InputError for a model that is none, TwinError for a folder without a twin, OSError for a file
    that cannot be read."""
    if name == "twin":
        from armside.sim.twin.twin import digest

        return digest(path)
    if name == "identification":
        return digest_of_file(path / "summary.json")
    if name in ("individual", "gears"):
        return digest_of_file(path)
    if name == "contour":  # the suffix decides how it is read
        return path.suffix.lower() + digest_of_file(path)
    return robot_content(path) if name == "robot" else model_content(path)


def resolved(cfg: LaserCfg, content: Content = content_of) -> dict[str, Any]:
    """Each option with the value that its run has, in the units of the options.

    None where it has no part in the run (the radius of a square), where a file says it (the corners
    of a contour), or where a model lacks it (the payload without a tool of its own).

    Raises ValueError for an unknown pose or options that misfit, OSError as `content`.
    """
    run = {field.name: getattr(cfg, field.name) for field in fields(cfg)}
    for name in ("gamma", "delta", "cutoff"):
        if len(set(run[name])) == 1:
            run[name] = run[name][:1]
    if cfg.law == "auto":
        run["law"] = "heuristic" if cfg.measure == "motor" else "inverse"
    if cfg.measure == "motor":
        run |= dict.fromkeys(("stiffness_error", "identification", "on_imu_fault"))
    run |= dict.fromkeys(("radius", "size", "width", "corner")) | dimensions(cfg)
    if cfg.contour is not None:
        run["shape"] = None
    # The place: position [mm] and orientation of the tool, and the pose that has both.
    ours = _rounded(tool_pose(cfg))
    named = (name for name, pose in cfg.cell.poses.items() if _rounded(pose) == ours)
    run |= {"pose": next(named, None), "position": ours[0], "quaternion": ours[1]}
    if cfg.payload is None or cfg.temperature is None:
        known = content("model", cfg.model) if cfg.model else _content_of_robot(cfg, content)
        of_model = _of_model(cfg.model or cfg.cell.xml, known)
        run |= {name: value for name, value in of_model.items() if run[name] is None}
    if "load-friction" in cfg.without:
        run["temperature"] = None
    if cfg.individual is not None:
        run["individual"] = str(cfg.individual)  # a column has one type
    return plain(run)


def identity(cfg: LaserCfg, content: Content = content_of) -> dict[str, Any]:
    """Everything a run depends on but its seed: resolved options, and the content of files. Raises
    as `resolved` and `content`."""
    what = resolved(cfg, content)
    if what["identification"]:  # it is known by how its place was written
        what["identified_at"] = plain((cfg.pose, cfg.position, cfg.quaternion))
    files = {name: getattr(cfg, name) for name in FILES if what[name]}
    found = {name: content(name, file) for name, file in files.items() if isinstance(file, Path)}
    if of_robot := _content_of_robot(cfg, content):
        found["robot"] = of_robot
    return what | found


def _content_of_robot(cfg: LaserCfg, content: Content) -> str:
    """Content of a robot file; empty for a robot with a name."""
    return "" if cfg.robot in CELLS else content("robot", Path(cfg.robot))


class _Known(NamedTuple):
    cfg: LaserCfg | None
    identity: dict[str, Any]  # the options themselves if they are refused
    error: str


class Resolver:
    """Resolves the configurations of one grid, options of `armside laser` that are not left out:
    each once, whatever its seeds, and each file once."""

    def __init__(self) -> None:
        self._content = cache(content_of)
        self._known = lru_cache(REMEMBERED)(self._resolve)

    def key(self, options: Mapping[str, Any], seed: int) -> str:
        """Sixteen hexadecimal digits of the whole configuration. One that cannot be run has a key
        too."""
        what = self._known(tuple(options.items())).identity
        return digest_of(what | {"experiment": "laser", "seed": seed})[:16]

    def refused(self, options: Mapping[str, Any]) -> str:
        """Why options cannot be run, as far as is known before the robot moves; empty if they can
        be."""
        known = self._known(tuple(options.items()))
        if (cfg := known.cfg) is None:
            return known.error
        try:
            asked, content = cut(cfg), _content_of_robot(cfg, self._content)
            if cfg.model is not None:
                content += self._content("model", cfg.model)
            source = cfg.model or cfg.cell.xml
            if content and (wrong := _geometry_error(cfg.robot, source, content)):
                return wrong
            if cfg.twin is not None:
                from armside.sim.twin.twin import stored_twin

                stored_twin(cfg.twin).check(asked)
        except (ValueError, OSError) as error:
            return one_line(error)
        return known.error

    def _resolve(self, items: tuple[tuple[str, Any], ...]) -> _Known:
        options, cfg = dict(items), None
        try:
            cfg = LaserCfg(**options)
            return _Known(cfg, identity(cfg, self._content), "")
        except (ValueError, OSError) as error:
            return _Known(cfg, {"refused": plain(options)}, one_line(error))


def key_of(options: Mapping[str, Any], seed: int) -> str:
    """See `Resolver.key`."""
    return Resolver().key(options, seed)


def _rounded(pose: ToolPose) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Position [mm] and quaternion, without the noise of a change of units."""
    position = tuple(round(x / MM, 9) for x in pose.position)
    return position, tuple(round(q, 12) for q in pose.quaternion)


@cache
def _of_model(source: Path, content: str) -> dict[str, float | None]:
    """Payload [kg] and temperature [deg C] of a robot's file; None where it has none. content: of
    that file, where it may change."""
    model = load_model(source)
    tool = mujoco.mj_name2id(model.mj, mujoco.mjtObj.mjOBJ_BODY, "tool")
    warm = Effect.LOAD_FRICTION in available(model)
    return {
        "payload": float(model.mj.body_mass[tool]) if tool >= 0 else None,
        "temperature": scalar(model.mj, "gear_temperature") if warm else None,
    }


@cache
def _geometry_error(robot: str, source: Path, content: str) -> str:
    """Why a file is no model of the robot; empty if it is one. content: of that file, and of a
    robot's."""
    try:
        cell_model(find_cell(robot), source)
    except ModelError as error:
        return one_line(error)
    return ""


def digest_of_file(file: Path) -> str:
    """Raises ValueError or OSError for a file that cannot be read."""
    return hashlib.sha256(check_file(file).read_bytes()).hexdigest()


def model_content(file: Path) -> str:
    """Hash of an MJCF and of the files that it includes. Raises InputError for one that is none."""
    try:
        parts = mujoco.mju_getXMLDependencies(str(check_file(file)))
    except mujoco.FatalError as error:
        raise InputError(f"{file} is not a usable MJCF model: {error}") from error
    return _together([digest_of_file(file), *sorted(digest_of_file(Path(part)) for part in parts)])


def robot_content(file: str | Path) -> str:
    """Hash of a robot file, and of the MJCF and URDF that it names. Raises ValueError, OSError."""
    file = Path(file)
    xml, urdf = read_cell(file).xml, read_toml(file, lambda data: data.get("urdf"))
    parts = [digest_of_file(file), model_content(xml)]
    if urdf is not None:
        parts.append(digest_of_file(file.parent / str(urdf).partition("#")[0]))
    return _together(parts)


def _together(digests: list[str]) -> str:
    return hashlib.sha256("".join(digests).encode()).hexdigest()

"""Geoms of a MuJoCo model as Rerun shapes, body by body, in their body's frame."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
import rerun as rr
from mujoco import mjtGeom

LARGEST_VISUAL_GROUP = 2
"""MuJoCo's viewers show groups 0 to 2; by convention collision shapes are in 3."""
FLOOR = 3.0
"""Half side of an infinite plane as drawn [m]."""


def body_entity(mj: mujoco.MjModel, body: int, prefix: str = "robot") -> str:
    """Entity of a body in a replay."""
    return f"{prefix}/{mj.body(body).name or f'body_{body}'}"


def shapes(mj: mujoco.MjModel, prefix: str = "robot") -> Iterator[tuple[str, rr.AsComponents]]:
    """Entity and shape of each visible geom type of each body; poses are in the body's frame."""
    visible = (mj.geom_group <= LARGEST_VISUAL_GROUP) & (_colours(mj)[:, 3] > 0)
    for body in range(mj.nbody):
        for kind in np.unique(mj.geom_type[(mj.geom_bodyid == body) & visible]):
            geoms = np.flatnonzero((mj.geom_bodyid == body) & (mj.geom_type == kind) & visible)
            name = mjtGeom(kind).name.removeprefix("mjGEOM_").lower()
            if kind == mjtGeom.mjGEOM_MESH:
                for g in geoms:
                    yield f"{body_entity(mj, body, prefix)}/mesh_{g}", _mesh(mj, int(g))
            elif (shape := _primitive(mj, mjtGeom(kind), geoms)) is not None:
                yield f"{body_entity(mj, body, prefix)}/{name}", shape


def _colours(mj: mujoco.MjModel) -> np.ndarray:
    """Colours (ngeom, 4), 0..255; a material's colour overrides the geom's own."""
    rgba, material = mj.geom_rgba.copy(), mj.geom_matid
    rgba[material >= 0] = mj.mat_rgba[material[material >= 0]]
    return np.rint(255 * rgba).astype(np.uint8)


def _primitive(mj: mujoco.MjModel, kind: mjtGeom, geoms: np.ndarray) -> rr.AsComponents | None:
    """Batch of shapes; kinds that Rerun cannot draw are left out."""
    size, centre, lengths = mj.geom_size[geoms], mj.geom_pos[geoms], 2 * mj.geom_size[geoms, 1]
    common: dict[str, Any] = {
        "quaternions": np.roll(mj.geom_quat[geoms], -1, axis=1),  # Rerun has w last
        "colors": _colours(mj)[geoms],
        "fill_mode": "solid",
    }
    match kind:
        case mjtGeom.mjGEOM_BOX:
            return rr.Boxes3D(centers=centre, half_sizes=size, **common)
        case mjtGeom.mjGEOM_PLANE:
            half = np.where(size[:, :2] > 0.0, size[:, :2], FLOOR)
            flat = np.column_stack([half, np.full(len(half), 1e-3)])
            return rr.Boxes3D(centers=centre - [0.0, 0.0, 2e-3], half_sizes=flat, **common)
        case mjtGeom.mjGEOM_SPHERE | mjtGeom.mjGEOM_ELLIPSOID:
            half = size[:, [0, 0, 0]] if kind == mjtGeom.mjGEOM_SPHERE else size
            return rr.Ellipsoids3D(centers=centre, half_sizes=half, **common)
        case mjtGeom.mjGEOM_CYLINDER:
            return rr.Cylinders3D(centers=centre, lengths=lengths, radii=size[:, 0], **common)
        case mjtGeom.mjGEOM_CAPSULE:
            # A capsule of Rerun starts at its origin, one of MuJoCo is centred there.
            w, x, y, z = mj.geom_quat[geoms].T
            axis = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
            start = centre - size[:, 1:2] * np.column_stack(axis)
            return rr.Capsules3D(translations=start, lengths=lengths, radii=size[:, 0], **common)
    return None


def _mesh(mj: mujoco.MjModel, geom: int) -> rr.Mesh3D:
    """A mesh, moved into its body's frame."""
    mesh, R = int(mj.geom_dataid[geom]), np.empty(9)
    vertices = mj.mesh_vert[mj.mesh_vertadr[mesh] :][: mj.mesh_vertnum[mesh]]
    faces = mj.mesh_face[mj.mesh_faceadr[mesh] :][: mj.mesh_facenum[mesh]]
    mujoco.mju_quat2Mat(R, mj.geom_quat[geom])
    placed = vertices @ R.reshape(3, 3).T + mj.geom_pos[geom]
    colour = _colours(mj)[geom]
    return rr.Mesh3D(vertex_positions=placed, triangle_indices=faces, albedo_factor=colour)

"""Pictures of a model without a window, by MuJoCo's own renderer on EGL or OSMesa."""

import os
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..records.files import InputError

Image = NDArray[np.uint8]


class NoGraphicsError(InputError):
    """This machine has no OpenGL to draw with."""


class Offscreen:
    """Draws a model; a context manager, as graphics memory is freed by hand.

    MUJOCO_GL=osmesa draws on the CPU by OSMesa; EGL is the default. Raises NoGraphicsError where
    neither is there, or the driver refuses.
    """

    def __init__(self, mj: mujoco.MjModel, width: int, height: int) -> None:
        self._rect = mujoco.MjrRect(0, 0, width, height)
        mj.vis.global_.offwidth, mj.vis.global_.offheight = width, height
        mj.vis.quality.offsamples = 4
        self._gl = _context(width, height)
        try:
            self._gl.make_current()
            self._scene = mujoco.MjvScene(mj, maxgeom=2000)
            self._context = mujoco.MjrContext(mj, mujoco.mjtFontScale.mjFONTSCALE_150.value)  # pyright: ignore[reportAttributeAccessIssue]
        except Exception as error:
            self._gl.free()
            raise NoGraphicsError(f"cannot draw without window: {error}") from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)  # pyright: ignore[reportAttributeAccessIssue]
        self.mj = mj

    def __enter__(self) -> "Offscreen":
        return self

    def __exit__(self, *_: object) -> None:
        self._context.free()
        self._gl.free()

    def draw(self, data: mujoco.MjData, camera: mujoco.MjvCamera) -> Image:
        """(height, width, 3), of a state after `mj_forward` or `mj_kinematics` and cameras."""
        option, everything = mujoco.MjvOption(), mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self.mj, data, option, None, camera, everything, self._scene)
        mujoco.mjr_render(self._rect, self._scene, self._context)  # pyright: ignore[reportAttributeAccessIssue]
        image = np.empty((self._rect.height, self._rect.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(image, None, self._rect, self._context)  # pyright: ignore[reportAttributeAccessIssue]
        return image[::-1]


def drawn_model(mj: mujoco.MjModel, source: Path, own: Path | None = None) -> mujoco.MjModel:
    """Robot on its floor where a scene lies beside its file `source`, or the model itself.

    own: MJCF file that takes the place of `source` in the scene, such as robot.xml of a run.
    """
    file = source.with_name(f"{source.stem}_scene.xml")
    if not file.is_file():
        return mj
    if own is None:
        scene = mujoco.MjModel.from_xml_path(str(file))
    else:
        scene = mujoco.MjModel.from_xml_string(file.read_text(), {source.name: own.read_bytes()})
    return scene if scene.nq == mj.nq else mj


def named_camera(mj: mujoco.MjModel, name: str) -> mujoco.MjvCamera:
    """Camera of the model, or a free one around its centre where it has none of that name."""
    camera = mujoco.MjvCamera()
    index = mujoco.mj_name2id(mj, mujoco.mjtObj.mjOBJ_CAMERA, name)
    if index >= 0:
        camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, index
        return camera
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = mj.stat.center
    camera.distance, camera.azimuth, camera.elevation = 1.8 * mj.stat.extent, 130.0, -15.0
    return camera


def widen(mj: mujoco.MjModel, data: mujoco.MjData, camera: mujoco.MjvCamera, aspect: float) -> None:
    """Widen the angle of a fixed camera where a shape would be cut off, after `mj_forward`."""
    if camera.type != mujoco.mjtCamera.mjCAMERA_FIXED:
        return
    i, shapes = camera.fixedcamid, mj.geom_rbound > 0.0  # an endless floor has none
    at = data.geom_xpos[shapes] - data.cam_xpos[i]
    across = np.abs(at @ data.cam_xmat[i].reshape(3, 3)) + mj.geom_rbound[shapes, np.newaxis]
    half = np.maximum(across[:, 0] / aspect, across[:, 1]) / (
        across[:, 2] - 2.0 * mj.geom_rbound[shapes]
    )
    angle = 2.0 * float(np.degrees(np.arctan(half.max(initial=0.0))))
    mj.cam_fovy[i] = max(mj.cam_fovy[i], angle)


def _context(width: int, height: int):
    """OpenGL context. Its libraries are looked for when this is called, not before."""
    backend = os.environ.get("MUJOCO_GL", "egl").lower()
    os.environ.setdefault("PYOPENGL_PLATFORM", "osmesa" if backend == "osmesa" else "egl")
    try:
        if backend == "osmesa":
            from mujoco.osmesa import GLContext
        else:
            from mujoco.egl import GLContext
        return GLContext(width, height)
    except Exception as error:  # PyOpenGL raises many types for it
        raise NoGraphicsError(
            f"cannot draw without window: no {backend.upper()} ({type(error).__name__}: {error}); "
            "on Debian install libegl1 and libgl1-mesa-dri, or set MUJOCO_GL=osmesa with libosmesa6"
        ) from error

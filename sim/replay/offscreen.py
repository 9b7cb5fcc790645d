"""Pictures of a model without a window, by MuJoCo's own renderer on EGL or OSMesa."""

import os
from pathlib import Path
from types import TracebackType

import mujoco
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]


class NoGraphicsError(RuntimeError):
    """This machine has no OpenGL to draw with."""


class Offscreen:
    """Draws a model; a context manager, as graphics memory is freed by hand.

    MUJOCO_GL=osmesa draws on the CPU by OSMesa; EGL is the default.

    Raises:
        NoGraphicsError: neither is there, or the driver refuses.
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
            raise NoGraphicsError(f"OpenGL does not draw here: {error}") from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)  # pyright: ignore[reportAttributeAccessIssue]
        self.mj = mj

    def __enter__(self) -> "Offscreen":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._context.free()
        self._gl.free()

    def draw(self, data: mujoco.MjData, camera: mujoco.MjvCamera) -> Image:
        """(height, width, 3), of a state after `mj_forward` or `mj_kinematics` and cameras."""
        option = mujoco.MjvOption()
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self.mj, data, option, None, camera, everything, self._scene)
        mujoco.mjr_render(self._rect, self._scene, self._context)  # pyright: ignore[reportAttributeAccessIssue]
        image = np.empty((self._rect.height, self._rect.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(image, None, self._rect, self._context)  # pyright: ignore[reportAttributeAccessIssue]
        return image[::-1]


def drawn_model(mj: mujoco.MjModel, source: Path) -> mujoco.MjModel:
    """The robot on its floor where a scene of it lies beside its file, or the model itself."""
    file = source.with_name(f"{source.stem}_scene.xml")
    if file.is_file():
        scene = mujoco.MjModel.from_xml_path(str(file))
        if scene.nq == mj.nq:
            return scene
    return mj


def named_camera(mj: mujoco.MjModel, name: str) -> mujoco.MjvCamera:
    """A camera of the model, or a free one around its middle where it has none of that name."""
    camera = mujoco.MjvCamera()
    index = mujoco.mj_name2id(mj, mujoco.mjtObj.mjOBJ_CAMERA, name)
    if index >= 0:
        camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, index
        return camera
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = mj.stat.center
    camera.distance, camera.azimuth, camera.elevation = 1.8 * mj.stat.extent, 130.0, -15.0
    return camera


def _context(width: int, height: int):
    """A context of OpenGL. Its libraries are looked for when this is called, not before."""
    backend = os.environ.get("MUJOCO_GL", "egl").lower()
    os.environ.setdefault("PYOPENGL_PLATFORM", "osmesa" if backend == "osmesa" else "egl")
    try:
        if backend == "osmesa":
            from mujoco.osmesa import GLContext
        else:
            from mujoco.egl import GLContext
        return GLContext(width, height)
    except Exception as error:  # PyOpenGL says the same with many types
        raise NoGraphicsError(
            f"no {backend.upper()} to draw with ({type(error).__name__}: {error}); on Debian "
            f"install libegl1 and libgl1-mesa-dri, or set MUJOCO_GL=osmesa with libosmesa6"
        ) from error

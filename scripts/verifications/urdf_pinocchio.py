"""Pinocchio's own reading of a URDF file: pose, Jacobian and mass matrix of a chain."""

# pyright: reportMissingImports=false

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array


class PinocchioChain:
    """A chain of a file, from its root link to a tip, by the names of its joints.

    Raises ImportError without Pinocchio, and ValueError where Pinocchio does not read the file.
    """

    def __init__(self, file: Path, joints: Sequence[str], tip: str) -> None:
        import pinocchio as pin

        self._pin: Any = pin
        self._model = pin.buildModelFromUrdf(str(file))
        self._data = self._model.createData()
        missing = [name for name in (*joints, tip) if not self._model.existFrame(name)]
        if missing:
            raise ValueError(f"Pinocchio has no {missing[0]}")
        self._joints = [self._model.joints[self._model.getJointId(name)] for name in joints]
        self._columns = [joint.idx_v for joint in self._joints]
        self._tip = self._model.getFrameId(tip, pin.FrameType.BODY)

    def at(self, values: Array) -> tuple[Array, Array, Array]:
        """T_root_tip (4, 4), (v, omega) of the tip (6, n) and mass matrix (n, n) at joint values.

        Joints beside the chain stand at zero.
        """
        pin, model, data = self._pin, self._model, self._data
        q = pin.neutral(model)
        for joint, value in zip(self._joints, values, strict=True):
            both = (np.cos(value), np.sin(value))  # a continuous joint has two
            q[joint.idx_q : joint.idx_q + joint.nq] = both if joint.nq == 2 else value
        pin.framesForwardKinematics(model, data, q)
        T = np.array(data.oMf[self._tip].homogeneous)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = np.array(pin.computeFrameJacobian(model, data, q, self._tip, axes))
        upper = np.triu(pin.crba(model, data, q))
        D = upper + np.triu(upper, 1).T
        return T, J[:, self._columns], D[np.ix_(self._columns, self._columns)]

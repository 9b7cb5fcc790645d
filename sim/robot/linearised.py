"""Plant linearised along a run: state-space matrices of each sample from MuJoCo's derivatives.

x(t + 1) = A(t) x(t) + B(t) u(t), y = C x, for deviations x of (q, q_dot, activations) from the
run, q in the tangent space of the configuration, and u of the controls. Finite differences of one
step (`mjd_transitionFD`, central), chained over the physics steps of a sample. A control at the end
of its range has the derivative on the side within it.
"""

from warnings import warn

import mujoco
import numpy as np

from armside.arrays import Array
from armside.ilc.models.state_space import TimeVarying

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_DIFFERENCE = 1e-6  # of the finite differences; central ones are exact to its square


def linearised(
    model: mujoco.MjModel, states: Array, controls: Array, outputs: Array, steps: int = 1
) -> TimeVarying:
    """T_u from the controls to `outputs @ x` along a run.

    Args:
        states: (N, s), full physics states at the samples, as `mujoco.rollout` returns them.
        controls: (N, nu), held over the `steps` physics steps of each sample.
        outputs: (p, 2 nv + na), rows of C.

    Raises ValueError for arrays of other shapes, or a model integrated by RK4, whose step has no
    such derivative. Warns (RuntimeWarning) of contacts, which may slip, come or go beside the run.
    """
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        raise ValueError("a model with integrator RK4 is not linearised: use Euler or implicit")
    size = 2 * model.nv + model.na
    n_samples, wanted = len(states), mujoco.mj_stateSize(model, _STATE)
    shapes = states.shape, controls.shape, outputs.shape[1:]
    if shapes != ((n_samples, wanted), (n_samples, model.nu), (size,)) or n_samples == 0:
        needed = f"(N, {wanted}), (N, {model.nu}) and (p, {size}), N >= 1"
        given = f"{states.shape}, {controls.shape} and {outputs.shape}"
        raise ValueError(f"states, controls and outputs must have shapes {needed}, got {given}")
    if steps < 1:
        raise ValueError(f"steps must be >= 1, got {steps}")
    data, touching = mujoco.MjData(model), 0
    A, B = np.tile(np.eye(size), (n_samples, 1, 1)), np.zeros((n_samples, size, model.nu))
    A_step, B_step = np.zeros((size, size)), np.zeros((size, model.nu))
    for t in range(n_samples):
        mujoco.mj_setState(model, data, states[t], _STATE)
        data.ctrl[:] = controls[t]
        for _ in range(steps):
            mujoco.mjd_transitionFD(model, data, _DIFFERENCE, True, A_step, B_step, None, None)
            A[t], B[t] = A_step @ A[t], A_step @ B[t] + B_step
            mujoco.mj_step(model, data)
        touching += data.ncon > 0
    if touching:
        text = f"contacts in {touching} of {n_samples} samples: the linear model holds while none"
        warn(f"{text} slips, comes or goes", RuntimeWarning, stacklevel=2)
    return TimeVarying(A, B, np.repeat(outputs[None], n_samples, axis=0))

"""A plant linearised along its run predicts what a small change of the controls does."""

import mujoco
import numpy as np
import pytest

from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.sim.robot.linearised import linearised

ARM = """
<mujoco>
  <option timestep="0.002" gravity="0 0 -9.82"/>
  <worldbody>
    <body>
      <joint name="a" axis="0 1 0" damping="0.4"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="2"/>
      <body pos="0.4 0 0">
        <joint name="b" axis="0 1 0" damping="0.2"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="a" kp="60" kv="4"/>
    <general joint="b" dyntype="filter" dynprm="0.02" gainprm="25" biastype="affine"
             biasprm="0 -25 -2"/>
  </actuator>
</mujoco>
"""
N, STEPS = 120, 3


def run(model, controls):
    """Full physics states before each sample, (N, s), and joint angles (N, 2)."""
    data = mujoco.MjData(model)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    states, angles = [], []
    for control in controls:
        state = np.zeros(mujoco.mj_stateSize(model, kind))
        mujoco.mj_getState(model, data, state, kind)
        states.append(state)
        angles.append(data.qpos.copy())
        data.ctrl[:] = control
        for _ in range(STEPS):
            mujoco.mj_step(model, data)
    return np.array(states), np.array(angles)


def reference():
    t = np.linspace(0.0, 1.0, N)[:, None]
    return np.hstack((0.8 * np.sin(3.0 * t), -0.6 * np.sin(5.0 * t)))


@pytest.fixture(scope="module")
def along_the_run():
    model = mujoco.MjModel.from_xml_string(ARM)
    states, angles = run(model, reference())
    C = np.eye(2, 2 * model.nv + model.na)
    return model, angles, linearised(model, states, reference(), C, STEPS)


def test_a_small_change_of_the_controls_moves_the_arm_as_predicted(along_the_run):
    model, angles, T_u = along_the_run
    change = 1e-4 * np.cumsum(np.random.default_rng(0).standard_normal((N, 2)), axis=0)
    moved = run(model, reference() + change)[1] - angles
    # what is left is of second order in the change
    np.testing.assert_allclose(T_u.simulate(change), moved, atol=5e-3 * np.abs(moved).max())


def test_norm_optimal_learning_along_the_run_follows_the_reference(along_the_run):
    model, angles, T_u = along_the_run
    criterion = QuadraticCriterion(change=1e-6)
    law = NormOptimal(T_u=T_u, n_samples=N, criterion=criterion)
    # a wish that begins at rest: the angles at the start are given
    wish = 0.97 * angles + 0.03 * np.vstack((np.zeros((2, 2)), reference()[:-2]))
    u, error = np.zeros((N, 2)), wish - angles
    sizes = [np.linalg.norm(error)]
    for _ in range(2):
        u = law(u, error)
        error = wish - run(model, reference() + u)[1]
        sizes.append(np.linalg.norm(error))
    assert sizes[1] < 0.2 * sizes[0]
    assert sizes[2] < sizes[1]


def test_arrays_of_other_shapes_are_refused(along_the_run):
    model = along_the_run[0]
    with pytest.raises(ValueError, match=r"must have shapes \(N, 6\), \(N, 2\) and \(p, 5\)"):
        linearised(model, np.zeros((4, 3)), np.zeros((4, 2)), np.eye(2, 5))
    rk4 = mujoco.MjModel.from_xml_string(ARM.replace("timestep", 'integrator="RK4" timestep'))
    given = np.zeros((4, 6)), np.zeros((4, 2)), np.eye(2, 5)
    with pytest.raises(ValueError, match="steps must be >= 1"):
        linearised(model, *given, 0)
    with pytest.raises(ValueError, match="a model with integrator RK4 is not linearised"):
        linearised(rk4, *given)


SPHERE = """
<mujoco>
  <option timestep="0.002"/>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body pos="0 0 0.05">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="z" type="slide" axis="0 0 1"/>
      <geom type="sphere" size="0.05" mass="1"/>
    </body>
  </worldbody>
  <actuator><motor joint="x"/></actuator>
</mujoco>
"""


def test_contacts_along_the_run_are_named():
    """A sphere pushed over a plane slips: no linear model holds."""
    model = mujoco.MjModel.from_xml_string(SPHERE)
    controls = np.full((5, 1), 12.0)
    states, _ = run(model, controls)
    with pytest.warns(RuntimeWarning, match=r"contacts in \d of 5 samples: .* while none slips"):
        linearised(model, states, controls, np.eye(1, 4), STEPS)

"""Springs and dampers of the robots: static deflection, pose of rest, logarithmic decrement."""

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from armside import assets
from armside.ilc.models.two_mass import TwoMassJoint
from armside.sim.robot.flexibility import Flexibility, variant
from armside.sim.robot.linkage import Linkage
from armside.sim.robot.model import load_model
from armside.sim.robot.statics import Statics, anticipated_shift

JOINT = TwoMassJoint()
STEP = 1e-4
"""[s]; Euler shifts phase by omega h / 2 and no more."""
RESONANCE = np.sqrt(JOINT.k / JOINT.Ja) / (2 * np.pi)
"""[Hz], of the arm on its spring: 1.13."""


def mjcf():
    """In arm-side coordinates the motor angle is rg q_m, its inertia Jm / rg^2."""
    rg2 = JOINT.rg**2
    small = 1e-9  # MuJoCo wants an inertia in every moving body
    return f"""
    <mujoco>
      <option timestep="{STEP}" integrator="Euler" gravity="0 0 0">
        <flag contact="disable"/>
      </option>
      <worldbody>
        <body>
          <joint name="motor" axis="0 0 1" armature="{JOINT.Jm / rg2}" damping="{JOINT.fm / rg2}"/>
          <joint name="flex" axis="0 0 1" stiffness="{JOINT.k}" damping="{JOINT.d}"/>
          <inertial pos="0 0 0" mass="1" diaginertia="{JOINT.Ja} {JOINT.Ja} {JOINT.Ja + small}"/>
        </body>
      </worldbody>
      <actuator><motor joint="motor" gear="{JOINT.kt / JOINT.rg}"/></actuator>
    </mujoco>"""


def swept_response(hertz):
    """Complex response from voltage to (q_m, q_a) at one frequency, after the transient."""
    model = mujoco.MjModel.from_xml_string(mjcf())
    data = mujoco.MjData(model)
    # The slowest poles of G_m besides the integrator decay with 2.5 1/s: 12 s leave nothing.
    settle, periods = 12.0, 4
    n_settle = round(settle / STEP)
    n = round(periods / hertz / STEP)
    omega = 2 * np.pi * periods / (n * STEP)
    t = np.arange(n_settle + n) * STEP
    voltage = np.cos(omega * t)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    states, _ = rollout.rollout(model, data, initial_state=state, control=voltage[:, None])
    # states follow the step: row i belongs to t = (i + 1) h
    time = states[0, n_settle:, 0]
    angles = states[0, n_settle:, 1:3]
    motor, arm = angles[:, 0] / JOINT.rg, angles.sum(axis=1)
    # The integrator keeps a constant: it is orthogonal to whole periods.
    turn = np.exp(-1j * omega * time)
    return omega, 2 * np.mean(motor * turn), 2 * np.mean(arm * turn)


@pytest.mark.parametrize("part", [0.3, 0.7, 1.0, 1.3, 2.0])
def test_the_mjcf_joint_has_the_response_of_8_6_and_8_7_up_to_twice_the_resonance(part):
    omega, motor, arm = swept_response(part * RESONANCE)
    s = 1j * omega
    num, den = JOINT.motor_transfer
    G_m = np.polyval(num, s) / np.polyval(den, s)
    num, den = JOINT.arm_transfer
    G_a = np.polyval(num, s) / np.polyval(den, s)
    assert abs(motor / G_m - 1) < 0.01
    assert abs(arm / (G_m * G_a) - 1) < 0.01
    assert abs((arm / motor) / G_a - 1) < 0.01


POSE = np.array([0.2, 0.3, 0.1, 0.4, -0.6, 0.5])
XML = {"large": assets.LARGE_ROBOT_XML, "irb1400": assets.IRB1400_XML}
G = 9.82


@pytest.fixture(scope="module", params=XML)
def model(request):
    return load_model(XML[request.param])


def tool_of(model, qpos):
    data = mujoco.MjData(model.mj)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model.mj, data)
    mujoco.mj_comPos(model.mj, data)
    jacobian = np.empty((3, model.mj.nv))
    mujoco.mj_jacSite(model.mj, data, jacobian, None, model.mj.site("tool0").id)
    return data.site("tool0").xpos.copy(), jacobian @ Linkage(model.mj).tangent(data)


def test_a_weight_at_the_flange_deflects_the_tool_by_the_sum_of_its_springs(model):
    """F = m g at the tool: displacement J K^-1 J' F of all springs, to first order in F."""
    mass = 1e-3
    heavy = load_model(XML["large" if len(model.brakes) == 0 else "irb1400"])
    body = heavy.mj.body("disc").id
    site = heavy.mj.site("tool0").pos
    rest = Statics(model).equilibrium(POSE).qpos
    before, J = tool_of(model, rest)
    # a point mass at the flange beside what the disc weighs
    old, new = heavy.mj.body_mass[body], heavy.mj.body_mass[body] + mass
    heavy.mj.body_ipos[body] = (old * heavy.mj.body_ipos[body] + mass * site) / new
    heavy.mj.body_mass[body] = new
    mujoco.mj_setConst(heavy.mj, mujoco.MjData(heavy.mj))
    after, _ = tool_of(heavy, Statics(heavy).equilibrium(POSE).qpos)
    springs = model.springs
    stiffness = model.mj.jnt_stiffness[model.mj.dof_jntid[springs]]
    force = np.array([0.0, 0.0, -mass * G])
    expected = J[:, springs] @ ((J.T @ force)[springs] / stiffness)
    # gravity and balancing springs change the stiffness by a few per cent
    assert after - before == pytest.approx(expected, rel=0.1, abs=0.1 * np.abs(expected).max())
    assert expected[2] < 0.0


def test_the_robot_rests_where_every_spring_carries_its_load(model):
    """At equilibrium the unbalanced force of each spring is zero, and motors carry the rest."""
    equilibrium = Statics(model).equilibrium(POSE)
    data = mujoco.MjData(model.mj)
    data.qpos[:] = equilibrium.qpos
    mujoco.mj_forward(model.mj, data)
    Z = Linkage(model.mj).tangent(data)
    static = Z.T @ (data.qfrc_bias - data.qfrc_passive)
    assert np.abs(static[model.springs]).max() < 1e-6
    assert static[model.motor] == pytest.approx(equilibrium.holding_torque, abs=1e-6)
    assert equilibrium.qpos[model.motor] == pytest.approx(POSE, abs=1e-15)


def test_the_anticipated_shift_is_its_share_of_the_sag(design):
    """At rest: tool of the flexible equilibrium minus rigid tool, to first order, times 0.576."""
    model = design
    still = np.tile(POSE, (12, 1))
    shift = anticipated_shift(Statics(model), still, 0.004)
    sag = (
        tool_of(model, Statics(model).equilibrium(POSE).qpos)[0]
        - tool_of(model, model.posture @ POSE)[0]
    )
    assert np.linalg.norm(sag) > 1e-3
    # the linear sag leaves out that gravity acts on the deflected arm: 2 to 4 %
    share = model.drives.elastic_compensation
    assert shift[0] == pytest.approx(share * sag, abs=0.06 * share * np.linalg.norm(sag))


@pytest.fixture(scope="module")
def weightless():
    """The large robot without gravity and balancing cylinder: springs alone."""
    mj = mujoco.MjModel.from_xml_path(str(XML["large"]))
    mj.opt.gravity[:] = 0.0
    mj.tendon_stiffness[mj.tendon("balancing_cylinder").id] = 0.0
    return mj


STRUCTURE = ("tilt_x", "tilt_y", "lower_bend_x", "lower_twist_z", "elbow_torsion_x")
SPRINGS = [
    *(f"flex_{i}" for i in range(1, 7)),
    *(f"struct_{name}" for name in (*STRUCTURE, "elbow_lateral_z")),
]


@pytest.mark.parametrize("name", SPRINGS)
def test_a_plucked_spring_rings_at_its_frequency_and_decays_by_its_damping(weightless, name):
    """Every other joint is held by a huge rotor: one oscillator, in the file's own time step.

    Decrement and period of k and d on the inertia beyond the hinge; integration adds no damping.
    """
    mj, data = weightless, mujoco.MjData(weightless)
    dof = mj.joint(name).dofadr[0]
    mass = np.empty((mj.nv, mj.nv))
    mujoco.mj_forward(mj, data)
    mujoco.mj_fullM(mj, data, mass)
    inertia, k, d = mass[dof, dof], mj.joint(name).stiffness[0], mj.joint(name).damping[0]
    w, zeta = np.sqrt(k / inertia), d / (2.0 * np.sqrt(k * inertia))
    own = mj.dof_armature.copy()
    mj.dof_armature[:] = np.where(np.arange(mj.nv) == dof, own, 1e12)
    try:
        data.qpos[dof] = 1e-4
        swing = np.empty((round(8 * 2 * np.pi / w / mj.opt.timestep), 2))
        for i in range(len(swing)):
            swing[i] = data.qpos[dof], data.qvel[dof]
            mujoco.mj_step(mj, data)
    finally:
        mj.dof_armature[:] = own
    # the analytic signal x - i x'/w of a lightly damped oscillator turns and shrinks evenly
    signal = swing[:, 0] - 1j * swing[:, 1] / w
    t = np.arange(len(swing)) * mj.opt.timestep
    rate = np.polyfit(t, np.log(np.abs(signal)), 1)[0]
    turn = np.polyfit(t, np.unwrap(np.angle(signal)), 1)[0]
    assert turn == pytest.approx(w * np.sqrt(1 - zeta**2), rel=0.01)
    assert -rate == pytest.approx(zeta * w, rel=0.05)


def test_forces_of_the_rigid_motion_contain_no_friction_and_no_damping(model):
    """Inertia and Coriolis forces are even in velocity, gravity does not depend on it."""
    rng = np.random.default_rng(0)
    phi, rate, acceleration = POSE + 0.1 * rng.standard_normal((3, 5, 6))
    statics = Statics(model)
    there, back = (statics.rigid_forces(phi, sign * rate, acceleration) for sign in (1.0, -1.0))
    assert there == pytest.approx(back, rel=1e-9, abs=1e-9)
    faster = statics.rigid_forces(phi, 2.0 * rate, acceleration)
    rest = statics.rigid_forces(phi, 0.0 * rate, acceleration)
    assert faster - rest == pytest.approx(4.0 * (there - rest), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("part", ["gear", "structure"])
def test_a_stiffer_variant_scales_the_springs_it_names_alone(model, part):
    xml = XML["large" if len(model.brakes) == 0 else "irb1400"]
    scaled = variant(xml, **{f"{part}_stiffness": 4.0})
    named = {"gear": "flex_", "structure": "struct_"}[part]
    for i in range(model.mj.njnt):
        name, stiffness = model.mj.joint(i).name, model.mj.jnt_stiffness[i]
        factor = 4.0 if name.startswith(named) else 1.0
        assert scaled.jnt_stiffness[i] == factor * stiffness, name
        dof = model.mj.jnt_dofadr[i]
        assert scaled.dof_damping[dof] == np.sqrt(factor) * model.mj.dof_damping[dof], name


def test_variants_without_springs_keep_their_mass_and_lose_their_hinges():
    full = load_model(assets.IRB1400_XML).mj
    names = {full.joint(i).name for i in range(full.njnt)}
    for flexibility, gone in (
        (Flexibility.RIGID, ("flex_", "struct_", "link_rod_x")),
        (Flexibility.GEARS, ("struct_", "link_rod_x")),
        (Flexibility.FULL, ("none",)),
    ):
        mj = variant(assets.IRB1400_XML, flexibility)
        kept = {mj.joint(i).name for i in range(mj.njnt)}
        assert kept == {name for name in names if not name.startswith(gone)}
        assert mj.body_mass.sum() == pytest.approx(full.body_mass.sum())

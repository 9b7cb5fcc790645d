"""Each alien effect by a signature that is computed another way, and unknown to the controller."""

import mujoco
import numpy as np
import pytest

from armside import assets
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.robot import alien
from armside.sim.robot.alien import ALIEN, AlienEffect
from armside.sim.robot.effects import Effect
from armside.sim.robot.individual import Individual, embodied
from armside.sim.robot.model import load_model
from armside.sim.robot.run import measured_angle
from armside.sim.robot.spread import Alien, Drawn
from armside.sim.robot.statics import Statics

DESIGN = load_model(assets.LARGE_ROBOT_XML)
PHI = np.array([0.1, 0.2, -0.1, 0.3, 0.4, -0.2])
LOADED = (Effect.LOAD_FRICTION,)
ARCMIN = np.pi / 180.0 / 60.0


def robot(*names, of_its_own=(), **state):
    """The design with effects of median size, and none of its own."""
    effects = tuple(AlienEffect(name) for name in names)
    return embodied(DESIGN, Individual(alien=effects), of_its_own, phi=PHI, **state)


def passive(model, qpos):
    data = mujoco.MjData(model.mj)
    data.qpos[:] = qpos
    mujoco.mj_forward(model.mj, data)
    return data.qfrc_passive.copy()


def at(model, phi):
    """Joint angles without deflections."""
    return model.posture @ phi


def test_a_gear_hardens_by_four_fifths_up_to_its_rated_torque():
    model, plain, dof = robot("hardening"), robot(), int(DESIGN.flex[1])
    k, qpos, step = 3.536e6, at(DESIGN, PHI), 1e-7
    wound = 0.5 * 32.0 * 242.73 / k  # half of the peak torque

    def slope(angle):
        ends = [qpos + np.eye(len(qpos))[dof] * (angle + d) for d in (-step, step)]
        low, high = ((passive(model, end) - passive(plain, end))[dof] for end in ends)
        return (low - high) / (2.0 * step)

    assert slope(0.0) == pytest.approx(0.0, abs=1e-4 * k)
    assert slope(wound) == pytest.approx(0.8 * k, rel=1e-4)
    assert slope(-wound) == pytest.approx(slope(wound), rel=1e-6)


def test_a_gear_that_is_loaded_and_unloaded_keeps_the_width_of_its_hysteresis():
    model, dof = robot("hysteresis"), int(DESIGN.flex[1])
    mj = model.mj
    mj.opt.gravity[:] = 0.0
    mj.eq_active0[model.brakes] = 1
    mj.tendon_stiffness[mj.tendon("balancing_cylinder").id] = 0.0
    data, friction, k = mujoco.MjData(mj), 0.03 * 0.5 * 32.0 * 242.73, 3.536e6
    n, peak = 4000, 3000.0
    wave = peak * np.interp(np.arange(3 * n) / n, [0, 0.5, 1.5, 2.5, 3], [0, 1, -1, 1, 1])
    angle = np.empty(3 * n)
    for i, torque in enumerate(wave):
        data.qfrc_applied[dof] = torque
        mujoco.mj_step(mj, data)
        angle[i] = data.qpos[dof]
    falling, rising = angle[n], angle[2 * n]  # without torque, from above and from below
    assert falling - rising == pytest.approx(2.0 * friction / k, rel=0.05)


def test_friction_within_a_run_follows_the_load_and_falls_as_grease_warms():
    drives, drive = DESIGN.drives, robot("run-friction", of_its_own=LOADED).own_drive
    time, ones = np.array([0.0, 1.0, 3.0]), np.ones((3, 6))
    gear = np.abs(drives.gear)
    peak = drives.torque_limit * gear
    slow = drive.applied(drives, np.array([0.0, 0.1, 0.2])[:, None] * peak, 1e-1 * ones, 0.0 * time)
    # F_cl = 0.0234 of the load, both over the peak torque: effects.load_friction
    assert slow[2] == pytest.approx(-0.0234 * 0.2 * drive.scale * peak, rel=1e-3)
    still = drive.applied(drives, 0.1 * peak * ones, 0.0 * ones, 0.0 * time)
    assert not still.any()
    warm = drive.applied(drives, 0.1 * peak * ones, -0.5 * ones, time)
    assert (np.diff(warm, axis=0) < 0.0).all()  # less friction drives on


def test_a_hose_pulls_its_three_axes_alike_and_no_other():
    plain, model = robot(), robot("hose")
    moved = PHI + np.array([0.3, 0.2, 0.1, 0.3, -0.1, 0.5])
    dof = DESIGN.motor
    pull = [
        (passive(model, at(model, p)) - passive(plain, at(plain, p)))[dof] for p in (PHI, moved)
    ]
    assert pull[0] == pytest.approx(-40.0 * (0.5 - 0.5) * np.array([0, 0, 0, 1, 1, 1]), abs=1e-6)
    assert pull[1] == pytest.approx(-40.0 * 0.7 * np.array([0, 0, 0, 1, 1, 1]), abs=1e-6)


def test_a_tool_bends_by_its_weight_over_its_bracket():
    model = robot("swinging-head")
    qpos, data = Statics(model).equilibrium(PHI).qpos, mujoco.MjData(model.mj)
    data.qpos[:] = qpos
    mujoco.mj_forward(model.mj, data)
    bent = [qpos[int(model.mj.joint(f"tool_{axis}").qposadr[0])] for axis in "yz"]
    along = data.body("tool").xmat.reshape(3, 3)[:, 0]
    weight = 40.0 * 9.81 * 0.25 * np.linalg.norm(np.cross(along, [0.0, 0.0, 1.0]))
    assert np.linalg.norm(bent) == pytest.approx(weight / 6e4, rel=3e-3)


def test_a_robot_bounces_on_its_floor_at_nine_hertz_and_stands_where_it_stood():
    model = robot("soft-floor")
    dof = int(model.mj.joint("floor_z").dofadr[0])
    data = mujoco.MjData(model.mj)
    mujoco.mj_forward(model.mj, data)
    M = np.zeros((model.mj.nv, model.mj.nv))
    mujoco.mj_fullM(model.mj, data, M)
    assert M[dof, dof] == pytest.approx(1740.0 + 3000.0, rel=1e-6)
    frequency = np.sqrt(float(model.mj.jnt_stiffness[model.mj.dof_jntid[dof]]) / M[dof, dof])
    assert frequency / 2.0 / np.pi == pytest.approx(9.0, rel=1e-6)
    assert abs(Statics(model).equilibrium(PHI).qpos[dof]) < 1e-5  # without: 3 mm


def test_an_eccentric_encoder_errs_once_and_three_times_a_revolution():
    model, n = robot("eccentric-encoder"), 256
    gear = DESIGN.drives.gear
    turn = 2.0 * np.pi * np.arange(n)[:, None] / n / gear
    motor = (measured_angle(model, turn, None) - turn) * gear
    heights = 2.0 * np.abs(np.fft.rfft(motor, axis=0)) / n
    counts = 2.0 * np.pi / 16384
    assert heights[1] == pytest.approx(np.full(6, 5.0 * ARCMIN), abs=counts)
    assert heights[3] == pytest.approx(np.full(6, 3.0 * ARCMIN), abs=counts)
    assert heights[2].max() < counts


def test_a_servo_of_another_make_has_its_notch_and_its_feedforward():
    drive, step, n = robot("own-servo").own_drive, 5e-4, 20_000
    time = step * np.arange(n)

    def gain(frequency):
        controls = np.zeros((n, 6, 3))
        controls[:, :, 0] = np.sin(2.0 * np.pi * frequency * time)[:, None]
        return np.abs(drive.commands(controls, step)[n // 2 :, 0, 0]).max()

    assert gain(11.0) == pytest.approx(0.3, abs=0.02)
    assert gain(1.0) == pytest.approx(1.0, abs=0.02)
    torque, still = np.outer([1.0, 3.0], np.ones(6)), np.zeros((2, 6))
    assert drive.feedforward(DESIGN.drives, torque, still)[1] == pytest.approx(np.full(6, 2.6))


@pytest.mark.parametrize("effect", [*ALIEN, "all"])
def test_an_alien_differs_starts_at_rest_and_the_controller_knows_nothing_of_it(effect):
    cut = Cut(radius=0.002, speed=0.06)
    plain, own = (
        prepare(Cut(radius=cut.radius, speed=cut.speed, individual=who))
        for who in (Drawn(3), Alien(3, effect=effect))
    )
    before, after = (each.loaded.run().truth.tool_position for each in (plain, own))
    rest = after[:400]  # 0.2 s
    assert np.abs(rest - rest[0]).max() < 2e-6
    assert np.linalg.norm((after - after[0]) - (before - before[0]), axis=1).max() > 2e-6
    assert np.array_equal(plain.loaded.reference, own.loaded.reference)
    for name in ("jnt_stiffness", "jnt_stiffnesspoly", "dof_frictionloss", "body_mass"):
        assert np.array_equal(getattr(own.nominal.mj, name), getattr(DESIGN.mj, name))
    assert own.nominal.own_drive is None


def test_an_alien_is_the_robot_of_its_number_besides():
    plain, own = (each.of(DESIGN) for each in (Drawn(5), Alien(5)))
    assert np.array_equal(plain.friction, own.friction)
    assert plain.hidden == own.hidden
    assert [each.name for each in own.alien] == list(ALIEN)
    sizes = {round(each.size, 12) for each in own.alien}
    assert len(sizes) == len(ALIEN)


def test_an_unknown_effect_is_refused_with_those_that_exist():
    with pytest.raises(ValueError, match=r"Unknown effect 'ghost'. Effects: hardening"):
        Alien(1, effect="ghost").of(DESIGN)


def test_hysteresis_is_of_the_rated_torque_of_each_gear():
    loss = robot("hysteresis").mj.dof_frictionloss[DESIGN.flex]
    assert loss == pytest.approx(0.015 * DESIGN.drives.torque_limit * DESIGN.drives.gear)
    assert alien.rated_torque(DESIGN)[0] == pytest.approx(0.5 * 30.0 * 220.0)


def test_friction_within_a_run_starts_at_the_temperature_and_is_left_out_with_load_friction():
    warm = robot("run-friction", of_its_own=LOADED, temperature=61.0).own_drive
    assert warm.temperature == 61.0
    assert robot("run-friction").own_drive is None


def test_encoders_of_two_robots_are_eccentric_in_other_phases():
    one, other = (
        embodied(DESIGN, Alien(number, effect="eccentric-encoder").of(DESIGN), (), phi=PHI)
        for number in (3, 4)
    )
    phases = [model.gear_error.phase[:, -2:] for model in (one, other)]
    assert np.abs(phases[0] - phases[1]).min() > 0.0
    assert np.unique(phases).size == 24

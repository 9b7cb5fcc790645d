"""The virtual robot rests, repeats bit by bit, follows its reference and reports limits."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from tests.calibration.experiments import learned

from armside import assets
from armside.sim.laser import Cut, prepare
from armside.sim.robot.effects import available, with_effects
from armside.sim.robot.individual import with_friction
from armside.sim.robot.mjcf import ModelError
from armside.sim.robot.model import load_model
from armside.sim.robot.run import run_batch
from armside.sim.robot.statics import Statics
from armside.sim.robot.virtual_robot import VirtualRobot


@pytest.fixture(scope="module")
def cut(design):
    return Cut(pose="p2").planned(Statics(design))


@pytest.fixture(scope="module")
def loaded(design, cut):
    return VirtualRobot(design).load(cut[1])


@pytest.fixture(scope="module")
def correction(cut):
    """A smooth correction of the size that learning finds."""
    t = np.linspace(0.0, 1.0, len(cut[1]))[:, None]
    return 1e-3 * np.sin(2 * np.pi * (2 + np.arange(6)) * t) * np.sin(np.pi * t) ** 2


def _ideal_encoder(design):
    return replace(design, drives=replace(design.drives, encoder_counts=0.0))


def test_a_robot_at_a_constant_reference_rests(design, cut):
    still = np.repeat(cut[1][:1], 120, axis=0)
    recording = VirtualRobot(design).load(still).run()
    moved = recording.truth.tool_position - recording.truth.tool_position[0]
    assert np.abs(moved).max() < 1e-7  # equilibrium is found to 1e-13 rad at each spring


def test_an_unstable_run_is_not_finite_from_there_on_and_leaves_no_file(
    loaded, monkeypatch, tmp_path
):
    monkeypatch.chdir(tmp_path)
    controls = loaded.controls.copy()
    controls[400:] = 1e300
    recordings = run_batch(
        [replace(loaded, controls=controls)] * 2, [None] * 2, [None] * 2, threads=2
    )
    for recording in recordings:
        assert np.isfinite(recording.error[:50]).all()
        assert np.isnan(recording.error[52:]).all()
    assert list(tmp_path.iterdir()) == []
    assert np.isfinite(loaded.run().error).all()  # what is kept between runs is not spoilt


def test_same_seed_same_bits_and_another_seed_other_noise(loaded, correction):
    first, again = (loaded.run(correction, np.random.default_rng(7)) for _ in range(2))
    other = loaded.run(correction, np.random.default_rng(8))
    for name in ("motor_angle", "motor_torque"):
        assert np.array_equal(getattr(first, name), getattr(again, name))
    assert np.array_equal(first.truth.tool_position, again.truth.tool_position)
    assert not np.array_equal(first.truth.tool_position, other.truth.tool_position)


def test_the_number_of_threads_changes_no_bit(loaded, correction):
    def runs(threads):
        rngs = [np.random.default_rng(seed) for seed in range(4)]
        return run_batch([loaded] * 4, [correction] * 4, rngs, threads=threads)

    for one, two in zip(runs(1), runs(2), strict=True):
        assert np.array_equal(one.motor_angle, two.motor_angle)
        assert np.array_equal(one.truth.qpos, two.truth.qpos)


@pytest.mark.parametrize("pose", ["p1", "p2", "p3"])
def test_halving_the_step_moves_the_tool_by_ten_micrometres_at_most(design, pose):
    """Without and with the correction that learning found, gear effects on, noise and quantisation
    off."""
    correction = learned(design, available(design), pose, iterations=5)["correction"]
    reference = prepare(Cut(pose=pose), nominal=design).loaded.reference
    tools = []
    for step in (0.0005, 0.00025):
        mj = mujoco.MjModel.from_xml_path(str(assets.LARGE_ROBOT_XML))
        mj.opt.timestep = step
        fine = _ideal_encoder(load_model(mj))
        fine = with_effects(fine, available(fine), phi=reference[0])
        loaded = VirtualRobot(fine).load(reference)
        runs = [loaded.run(correction[k]).truth.tool_position for k in (0, 5)]
        tools.append(np.array(runs)[:, :: round(0.0005 / step)])
    assert np.linalg.norm(tools[0] - tools[1], axis=2).max() < 10e-6


def test_log_is_the_truth_counted_by_the_encoder(loaded, design):
    recording = loaded.run()
    true = recording.truth.motor_angle[:: loaded.ratio]
    count = 2 * np.pi / 16384 / design.drives.gear
    assert np.abs(recording.motor_angle - true).max() <= 0.5 * count.max() * (1 + 1e-9)
    turns = recording.motor_angle / count
    assert np.abs(turns - np.rint(turns)).max() < 1e-6


def test_rows_of_the_truth_belong_to_one_instant(loaded, design):
    """Sensors and states of a step are half a step apart in a rollout; the record aligns them."""
    truth = loaded.run().truth
    data = mujoco.MjData(design.mj)
    for i in (0, 777, len(truth.time) - 1):
        data.qpos[:] = truth.qpos[i]
        mujoco.mj_kinematics(design.mj, data)
        assert data.site("tool0").xpos == pytest.approx(truth.tool_position[i], abs=1e-14)


def test_accelerometer_is_the_second_difference_of_its_position(loaded, design):
    truth = loaded.run().truth
    data, site = mujoco.MjData(design.mj), design.mj.site("imu").id
    position, R = [], []
    for q in truth.qpos:
        data.qpos[:] = q
        mujoco.mj_kinematics(design.mj, data)
        position.append(data.site_xpos[site].copy())
        R.append(data.site_xmat[site].reshape(3, 3).copy())
    step = design.timestep
    acceleration = np.diff(position, n=2, axis=0) / step**2
    specific = np.einsum("nij,nj->ni", np.array(R)[1:-1], truth.imu_acceleration[1:-1])
    difference = specific - np.array([0, 0, 9.82]) - acceleration
    # implicitfast evaluates the sensor before it adds the implicit part of the damping: first order
    # in the step, and largest where the modes of 130 Hz and above ring
    assert np.sqrt(np.mean(difference**2)) < 0.1


def test_a_constant_correction_moves_the_motors_by_itself(loaded):
    """The static gain from u to y is one."""
    shift = 2e-3
    ramp = np.minimum(np.arange(len(loaded.reference)) / 100.0, 1.0)[:, None]
    moved = loaded.run(shift * ramp * np.ones(6)).motor_angle - loaded.run().motor_angle
    # friction leaves each motor within Coulomb torque over kp of where it should be
    assert moved[-1] == pytest.approx(np.full(6, shift), abs=0.5e-3)


def test_more_friction_makes_a_larger_first_error(design, cut, loaded):
    rough = VirtualRobot(with_friction(design, 1.5)).load(cut[1])
    assert (np.abs(rough.run().error).max(axis=0) > np.abs(loaded.run().error).max(axis=0)).all()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.zeros((100, 5)), "shape"),
        (np.full((100, 6), np.nan), "finite"),
        (np.zeros(6), "shape"),
    ],
)
def test_invalid_references_and_corrections_are_refused(design, loaded, values, message):
    with pytest.raises(ValueError, match=message):
        VirtualRobot(design).load(values)
    with pytest.raises(ValueError, match="samples|" + message):
        loaded.run(values)


def test_a_file_that_is_no_robot_is_refused(tmp_path):
    other = assets.LARGE_ROBOT_XML.read_text().replace("motor_4", "engine_4")
    for text, said in (("<mujoco><nonsense/></mujoco>", "not a usable MJCF"), (other, "motor_4")):
        (tmp_path / "robot.xml").write_text(text)
        with pytest.raises(ModelError, match=said):
            load_model(tmp_path / "robot.xml")
    with pytest.raises(ModelError):
        load_model(tmp_path / "absent.xml")

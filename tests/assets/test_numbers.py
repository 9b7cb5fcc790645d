"""Numbers of the MJCF files against a second statement of their sources.

Sources: the data sets of the two robots (assets/README.md), thesis Table 4.2, 5.1 and 5.3.1, and
the trim that calibration found. Inertias are stated as radii of gyration, gains as
frequency and damping, calibrated numbers as factors: nothing is copied from the files.
"""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pytest
from tests.calibration.parameters import Trim, differing

from armside import assets, kinematics
from armside.sim.robot.mjcf import AXES
from armside.sim.robot.model import load_model

FILE_DIGITS = 1e-6  # relative; numbers in the files have six to eight digits
LIMIT_DIGITS = 1e-5  # [rad], [rad/s]


@dataclass(frozen=True)
class Source:
    """Data of one robot as its sources state them."""

    file: Path
    bodies: dict
    """kg, centre of mass [m], radii of gyration [m]."""
    rotor_inertia: tuple
    """[kg m^2]."""
    gear: tuple
    peak: tuple
    """[motor N m]."""
    coulomb: tuple
    viscous: tuple
    """[motor N m], [motor N m s/rad]."""
    static_over_coulomb: float
    stribeck: float
    """[motor rad/s]."""
    bristle: tuple
    """(2, 6): sigma0 [N m/rad] and sigma1 [N m s/rad], motor side."""
    range_deg: tuple
    speed_deg: tuple
    numerics: dict
    integrator: mujoco.mjtIntegrator


LARGE = Source(
    file=assets.LARGE_ROBOT_XML,
    bodies={
        "base": (380, (-0.19, 0.03, 0.13), (0.23, 0.29, 0.35)),
        "frame": (600, (0.08, -0.03, -0.18), (0.275, 0.28, 0.295)),
        "cylinder": (110, (0.10, -0.21, 0.02), (0.125, 0.183, 0.181)),
        # carried at its rod end, 0.25 m from the origin of the source
        "piston": (12, (-0.25 + 0.25, -0.21, -0.05), (0.05, 0.20, 0.195)),
        "lower_arm": (230, (0, -0.18, 0.478), (0.346, 0.347, 0.148)),
        "elbow": (190, (-0.05, 0, 0.12), (0.20, 0.19, 0.20)),
        "tube": (130, (0.70, 0, 0), (0.11, 0.32, 0.32)),
        "tilt": (40, (0.03, 0, 0), (0.068, 0.09, 0.092)),
        "disc": (8, (-0.017, 0, 0), (0.068, 0.049, 0.049)),
        "tool": (40, (0.25, 0, 0), (0.14, 0.14, 0.14)),
    },
    rotor_inertia=(5.0e-3, 5.9e-3, 4.0e-3, 1.6e-3, 1.2e-3, 0.9e-3),
    gear=(220, 242.73, 242.73, 145, 180, 100),
    peak=(30, 32, 26, 9, 8, 5),
    coulomb=(1.45, 1.54, 1.07, 0.43, 0.27, 0.24),
    viscous=(0.0132, 0.0141, 0.0114, 0.0040, 0.0035, 0.0022),
    static_over_coulomb=1.14,
    stribeck=15.0,
    bristle=tuple(np.outer((20.0, 0.3), np.array((30, 32, 26, 9, 8, 5)) / 26.0)),
    range_deg=((-180, 180), (-65, 80), (-180, 60), (-300, 300), (-120, 120), (-300, 300)),
    speed_deg=(100, 90, 90, 150, 120, 190),
    numerics={
        "encoder_counts": 16384,
        "correction_lag": 28.5,  # [Hz]
        "torque_noise": (1e-4, 20.0),  # of the peak torque, [Hz]
    },
    integrator=mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
)
TRIM = Trim(
    servo_frequency=(6.33, 6.10, 3.80, 8.83, 10.10, 10.60),
    servo_damping=1.15,
    velocity_feedforward=(0.89, 0.89, 0.84, 0.91, 0.77, 0.905),
    correction_delay=0.0138,
    elastic_compensation=0.576,
    gear_stiffness=1.04,
    gear_damping=0.7,
    gear_soft=0.169,
    lost_motion=0.14,
    structure_stiffness=1.01,
    structure_damping=0.25,
    gear_error=0.462,
    ripple=1.1,
    friction=(1.0, 0.892, 0.84, 0.627, 0.47, 0.3),
    static_excess=0.143,
    temperature=33.0,
    bristle_stiffness=20.0,
)
"""The result of calibration, as factors on the data set."""

IRB1400 = Source(
    file=assets.IRB1400_XML,
    bodies={
        "base": (62, (-0.05, 0, 0.15), (0.15, 0.17, 0.19)),
        "frame": (82, (0.02, 0, -0.06), (0.18, 0.19, 0.19)),
        "balancing_springs": (3, (0, 0, 0.1), (0.05, 0.05, 0.05)),
        "crank": (6, (-0.06, 0.05, 0), (0.10, 0.10, 0.10)),
        "rod": (4, (0, 0, 0.3), (0.17, 0.17, 0.025)),
        "lower_arm": (18, (0, -0.03, 0.26), (0.20, 0.20, 0.07)),
        "lever": (1, (-0.08, 0, 0), (0.06, 0.06, 0.06)),
        # of the housing's 34 kg at (-0.06, 0, 0.08) the lever has one
        "upper_arm": (33, (-(34 * 0.06 - 0.08) / 33, 0, 34 * 0.08 / 33), (0.10, 0.13, 0.13)),
        "tube": (12, (0.42, 0, 0), (0.055, 0.16, 0.16)),
        "tilt": (3.2, (0.02, 0, 0), (0.045, 0.045, 0.045)),
        "disc": (0.8, (-0.01, 0, 0), (0.03, 0.03, 0.03)),
        "imu_mount": (0.3, (0.02, -0.022, 0.055), (0.04, 0.04, 0.04)),
    },
    rotor_inertia=(1.3e-3, 1.3e-3, 1.3e-3, 2.0e-4, 1.8e-4, 1.6e-4),
    gear=(118, 118, 118, 60, 55, 50),
    peak=(9, 9, 9, 1.6, 1.6, 1.2),
    coulomb=(0.45, 0.55, 0.60, 0.25, 0.30, 0.15),
    viscous=(1.0e-3, 1.0e-3, 1.2e-3, 1.0e-3, 1.0e-3, 1.0e-3),
    static_over_coulomb=1.25,
    stribeck=5.0,
    bristle=tuple(np.outer((100.0, 0.2), (0.45, 0.55, 0.60, 0.25, 0.30, 0.15))),
    range_deg=((-170, 170), (-70, 70), (-65, 70), (-150, 150), (-115, 115), (-300, 300)),
    speed_deg=(120, 120, 120, 280, 280, 280),
    numerics={
        "encoder_counts": 2**12 - 1,  # thesis 5.3.1
        "encoder_noise": 0.3,  # counts
        "velocity_feedforward": np.ones(6),
        "friction_feedforward": 0.7,
        "friction_curve": 1.0,
        "correction_delay": 0.013,  # [s]
        "correction_lag": 28.5,  # [Hz]
        "elastic_compensation": 0.0,
        "torque_noise": (0.004, 150.0),
        "link_elbow": (0, -1, 1, 0, 0, 0),  # thesis (4.10)
        "link_rod_y": (0, 1, -1, 0, 0, 0),
    },
    integrator=mujoco.mjtIntegrator.mjINT_EULER,
)
IRB1400_SPRINGS = {  # [N m/rad], [N m s/rad]
    "flex_1": (2.7e5, 160),
    "flex_2": (3.7e5, 210),
    "flex_3": (2.7e5, 100),
    "flex_4": (2.0e4, 3),
    "flex_5": (1.5e4, 3),
    "flex_6": (1.0e4, 0.7),
    "struct_tilt_x": (3e6, 450),
    "struct_tilt_y": (3e6, 450),
    "struct_lower_bend_x": (8e5, 170),
    "struct_lower_twist_z": (6e5, 150),
    "struct_elbow_torsion_x": (1.5e5, 13),
    "struct_elbow_lateral_z": (3e5, 75),
}
ROBOTS = {"large": LARGE, "irb1400": IRB1400}


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    source = ROBOTS[request.param]
    return source, load_model(source.file)


def test_masses_and_inertias_are_those_of_the_data_set(robot):
    source, model = robot
    names = [model.mj.body(i).name for i in range(1, model.mj.nbody)]
    assert sorted(names) == sorted(source.bodies)
    for name, (mass, centre, radii) in source.bodies.items():
        body = model.mj.body(name)
        assert body.mass[0] == pytest.approx(mass, rel=FILE_DIGITS), name
        assert body.ipos == pytest.approx(centre, abs=1e-8), name
        assert body.iquat == pytest.approx([1, 0, 0, 0], abs=1e-12), name
        expected = mass * np.square(radii)
        assert np.sort(body.inertia) == pytest.approx(np.sort(expected), rel=2e-5), name


def test_springs_of_the_irb1400_are_those_of_the_data_set():
    mj = load_model(assets.IRB1400_XML).mj
    springs = {mj.joint(i).name for i in range(mj.njnt) if mj.jnt_stiffness[i] > 0.0}
    assert springs == set(IRB1400_SPRINGS)
    for name, (stiffness, damping) in IRB1400_SPRINGS.items():
        assert mj.joint(name).stiffness[0] == pytest.approx(stiffness), name
        assert mj.joint(name).damping[0] == pytest.approx(damping), name


def test_calibrated_numbers_of_the_large_robot_are_its_trim_of_the_data_set():
    """Springs, servo gains, bristles, gear effects and the correction path of all axes."""
    assert differing(assets.LARGE_ROBOT_XML, TRIM) == []


def test_springs_of_the_large_robot_are_the_trim_of_those_of_the_data_set():
    """Independent of the reference data in the calibration's own module."""
    mj = load_model(assets.LARGE_ROBOT_XML).mj
    gears = (3.4e6, 3900), (3.4e6, 3900), (2.0e6, 2300), (4.5e5, 110), (4.0e5, 200), (3.0e5, 50)
    for i, (stiffness, damping) in enumerate(gears, 1):
        gear = mj.joint(f"flex_{i}")
        assert gear.stiffness[0] == pytest.approx(TRIM.gear_stiffness * stiffness, rel=1e-6)
        assert gear.damping[0] == pytest.approx(TRIM.gear_damping * damping, rel=1e-6)
    structure = {
        "struct_tilt_x": (8e6, 5400),
        "struct_tilt_y": (8e6, 5400),
        "struct_lower_bend_x": (4e6, 3400),
        "struct_lower_twist_z": (2.5e6, 2100),
        "struct_elbow_torsion_x": (1e6, 330),
        "struct_elbow_lateral_z": (2e6, 1300),
    }
    for name, (stiffness, damping) in structure.items():
        hinge = mj.joint(name)
        assert hinge.stiffness[0] == pytest.approx(TRIM.structure_stiffness * stiffness)
        assert hinge.damping[0] == pytest.approx(TRIM.structure_damping * damping)


def test_the_large_robots_gear_effects_have_the_size_of_their_catalogues():
    """Lost motion 1-1.5 arcmin, errors 5, 15, 5, 2.5 arcsec, ripple 0.5 % of peak, each trimmed."""
    mj, arcsec = load_model(assets.LARGE_ROBOT_XML).mj, np.pi / 180 / 3600
    half = 0.5 * 60 * arcsec * np.array([1.0, 1.0, 1.0, 1.2, 1.2, 1.5])
    assert mj.numeric("gear_lost_motion").data == pytest.approx(
        TRIM.lost_motion * half, rel=FILE_DIGITS
    )
    stiff = np.array([mj.joint(f"flex_{i}").stiffness[0] for i in AXES])
    assert mj.numeric("gear_soft_stiffness").data == pytest.approx(TRIM.gear_soft * stiff)
    error = TRIM.gear_error * arcsec * np.array([5, 15, 5, 2.5])
    assert mj.numeric("gear_error").data == pytest.approx(error, rel=FILE_DIGITS)
    assert mj.numeric("torque_ripple").data == pytest.approx([TRIM.ripple * 0.005, 12])


def test_the_phases_of_the_gear_errors_are_those_drawn_once():
    """Uniform, of seed 2008, to three decimals."""
    phase = load_model(assets.LARGE_ROBOT_XML).mj.numeric("gear_error_phase").data
    drawn = np.random.default_rng(2008).uniform(0.0, 2.0 * np.pi, 24)
    assert phase == pytest.approx(drawn, abs=5.1e-4)


def test_drives_have_the_gears_rotors_and_limits_of_the_data_set(robot):
    source, model = robot
    drives, gear = model.drives, np.array(source.gear)
    assert drives.gear == pytest.approx(gear)
    assert model.mj.actuator_gear[:, 0] == pytest.approx(gear)
    assert model.mj.dof_armature[model.motor] == pytest.approx(
        gear**2 * source.rotor_inertia, rel=FILE_DIGITS
    )
    assert drives.torque_limit == pytest.approx(source.peak)
    assert drives.speed_limit == pytest.approx(np.deg2rad(source.speed_deg), abs=1e-4)
    assert model.joint_range == pytest.approx(np.deg2rad(source.range_deg), abs=LIMIT_DIGITS)
    assert model.mj.jnt_limited[model.mj.dof_jntid[model.motor]].all()


def test_limits_of_the_kinematic_description_are_those_of_the_data_set():
    limits = kinematics.IRB1400_LIMITS
    assert np.column_stack((limits.lower, limits.upper)) == pytest.approx(
        np.deg2rad(IRB1400.range_deg), abs=LIMIT_DIGITS
    )
    assert limits.speed == pytest.approx(np.deg2rad(IRB1400.speed_deg), abs=LIMIT_DIGITS)
    (linkage,) = limits.coupled
    assert (linkage.lower, linkage.upper) == pytest.approx(np.deg2rad((-70, 70)), abs=LIMIT_DIGITS)
    assert list(linkage.coefficients) == [0, -1, 1, 0, 0, 0]
    elbow = load_model(assets.IRB1400_XML).mj.joint("link_elbow")
    assert elbow.range == pytest.approx([linkage.lower, linkage.upper], abs=LIMIT_DIGITS)


def test_friction_of_the_drives_is_that_of_the_data_set(robot):
    source, model = robot
    drives = model.drives
    assert drives.coulomb_friction == pytest.approx(source.coulomb)
    assert drives.static_friction == pytest.approx(
        source.static_over_coulomb * np.array(source.coulomb), rel=FILE_DIGITS
    )
    assert drives.stribeck_speed == pytest.approx(np.full(6, source.stribeck))
    assert drives.viscous_friction == pytest.approx(source.viscous)
    bristles = model.mj.actuator_dynprm[:, 5:7].T
    assert bristles == pytest.approx(np.array(source.bristle), rel=FILE_DIGITS)


def test_inertias_obey_the_triangle_inequality(robot):
    inertia = np.sort(robot[1].mj.body_inertia[1:], axis=1)
    assert (inertia[:, 0] > 0.0).all()
    assert (inertia[:, 0] + inertia[:, 1] >= inertia[:, 2]).all()


def test_it_stays_quiet_under_noise(robot):
    mj, rng = robot[1].mj, np.random.default_rng(0)
    data = mujoco.MjData(mj)
    for _ in range(400):
        data.ctrl[:] = rng.standard_normal(mj.nu)
        mujoco.mj_step(mj, data)
    assert np.isfinite(data.qpos).all()
    assert not data.warning.number.any()


def test_what_the_controller_knows_is_what_the_data_set_says(robot):
    source, model = robot
    for name, values in source.numerics.items():
        assert model.mj.numeric(name).data == pytest.approx(np.atleast_1d(values)), name


def test_physics_runs_with_the_step_and_gravity_of_the_thesis(robot):
    source, model = robot
    option = model.mj.opt
    assert option.timestep == 0.0005
    assert option.integrator == source.integrator
    assert option.gravity == pytest.approx([0, 0, -9.82])
    # implicit joint damping would be numerical damping that the accelerometer does not see
    explicit = source.integrator == mujoco.mjtIntegrator.mjINT_EULER
    assert bool(option.disableflags & mujoco.mjtDisableBit.mjDSBL_EULERDAMP) == explicit


def test_each_sensor_measures_its_own_axis_or_site(robot):
    mj = robot[1].mj
    for i in AXES:
        assert mj.sensor(f"axis_{i}_pos").objid[0] == mj.joint(f"motor_{i}").id
        assert mj.sensor(f"axis_{i}_torque").objid[0] == mj.actuator(f"axis_{i}").id
    for sensor, site in (("imu_acc", "imu"), ("imu_gyro", "imu"), ("tool0_pos", "tool0")):
        assert mj.sensor(sensor).objid[0] == mj.site(site).id
    assert not mj.sensor_noise.any()
    assert not mj.sensor_cutoff.any()


def test_hinges_of_a_spring_turn_about_its_axis(robot):
    """Gears about their motors; the base tilts about the floor, the structure about its links."""
    _, model = robot
    data = mujoco.MjData(model.mj)
    mujoco.mj_kinematics(model.mj, data)
    for i in AXES:
        motor, flex = data.joint(f"motor_{i}"), data.joint(f"flex_{i}")
        assert motor.xaxis == pytest.approx(flex.xaxis, abs=1e-12)
        assert motor.xanchor == pytest.approx(flex.xanchor, abs=1e-12)
    for name, axis in (("tilt_x", 0), ("tilt_y", 1), ("lower_bend_x", 0), ("lower_twist_z", 2)):
        assert data.joint(f"struct_{name}").xaxis == pytest.approx(np.eye(3)[axis], abs=1e-12)
    for name in ("tilt_x", "tilt_y"):
        assert data.joint(f"struct_{name}").xanchor == pytest.approx([0, 0, 0], abs=1e-12)
    assert data.joint("struct_elbow_torsion_x").xaxis == pytest.approx([1, 0, 0], abs=1e-12)
    assert data.joint("struct_elbow_lateral_z").xaxis == pytest.approx([0, 0, 1], abs=1e-12)
    for name, joint in (("lower_bend_x", "motor_2"), ("lower_twist_z", "motor_2")):
        anchor = data.joint(joint).xanchor
        assert data.joint(f"struct_{name}").xanchor == pytest.approx(anchor, abs=1e-12)


def test_constraints_of_the_irb1400_are_stiff_and_its_brakes_released():
    """Two steps of time constant, the shortest that Euler allows, and 1e-4 of compliance."""
    mj = load_model(assets.IRB1400_XML).mj
    assert mj.eq_solref == pytest.approx(np.tile([2 * mj.opt.timestep, 1.0], (mj.neq, 1)))
    assert mj.eq_solimp[:, :2] == pytest.approx(np.full((mj.neq, 2), 0.9999))
    brakes = [mj.eq(f"brake_{i}") for i in AXES]
    assert [int(brake.obj1id[0]) for brake in brakes] == [mj.joint(f"motor_{i}").id for i in AXES]
    assert not any(mj.eq_active0[brake.id] for brake in brakes)
    assert mj.eq_active0[mj.eq("rod_to_lever").id]


def test_balancing_cylinder_and_springs_have_their_stiffness_and_free_length():
    large, small = (load_model(source.file).mj for source in (LARGE, IRB1400))
    cylinder = large.tendon("balancing_cylinder").id
    assert large.tendon_stiffness[cylinder] == pytest.approx(100e3)
    assert large.tendon_lengthspring[cylinder] == pytest.approx([0.481 - 24e3 / 100e3] * 2)
    springs = small.tendon("balancing_springs").id
    assert small.tendon_stiffness[springs] == pytest.approx(170.0 / (0.25 * 0.30))
    assert small.tendon_lengthspring[springs] == pytest.approx([0.0, 0.0])

"""Recordings that cannot be right, for `gears` and for `imu --recordings`: one error names why."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside.sim.gears import GearsCfg, analyse_gears
from armside.sim.imu.chapter5_recorded import process
from armside.sim.recordings import Stream, read_motion
from armside.sim.recordings.alignment.checks import check_pair
from armside.sim.recordings.tables import write_motion_tables


def stream(name, change):
    """Change of the values of an instrument of a recording."""

    def spoil(one):
        known = getattr(one, name)
        return replace(one, **{name: Stream(known.time, change(known.values))})

    return spoil


def encoders(change):
    return stream("encoders", change)


def imu(factor):
    return stream("imu", lambda values: values * factor)


def columns(order):
    """The IMU's six columns in another order."""
    return stream("imu", lambda values: values[:, order])


def without_gravity(values):
    """Its mean taken off the specific force, as some drivers do."""
    return values - values.mean(axis=0) * np.repeat([1.0, 0.0], 3)


def between(name, keep):
    """Samples of an instrument at the times that `keep` takes."""

    def spoil(one):
        stream = getattr(one, name)
        rows = keep(stream.time)
        return replace(one, **{name: Stream(stream.time[rows], stream.values[rows])})

    return spoil


WRONG = {
    "degrees for radians": (encoders(np.degrees), "are the angles in degrees"),
    "radians twice": (encoders(np.radians), "IMU"),
    "swapped": (encoders(lambda phi: phi[:, [1, 0, 2]]), "motors 1 and 2 swapped"),
    "reversed": (encoders(lambda phi: phi * [1, 1, -1]), "the sign of motor 3 reversed"),
    "one motor not logged": (
        encoders(lambda phi: np.where(np.arange(3) == 1, phi[0], phi)),
        "motor_angle_2 does not move, and the gyro",
    ),
    "no motor moves": (encoders(lambda phi: np.tile(phi[0], (len(phi), 1))), "does not move"),
    "too few motors": (encoders(lambda phi: phi[:, :2]), "has 3 motors, the recording has 2"),
    "gyro in degrees": (imu(np.repeat([1.0, 57.3], 3)), "degrees per second"),
    "accelerometer in g": (imu(np.repeat([1 / 9.81, 1.0], 3)), "in g"),
    "accelerometer in mm/s^2": (imu(np.repeat([1e3, 1.0], 3)), "in mm/s"),
    "tracker in millimetres": (stream("tracker", lambda p: 1e3 * p), "millimetres"),
    "another motion": (
        stream("imu", lambda values: np.random.default_rng(0).normal(size=values.shape)),
        "did not see the same motion",
    ),
    "sensors exchanged": (columns([3, 4, 5, 0, 1, 2]), "angular velocities are exchanged"),
    "axes exchanged": (columns([1, 0, 2, 4, 3, 5]), "angular rate are left-handed"),
    "gyro reversed": (imu(np.repeat([1.0, -1.0], 3)), "angular rate are left-handed"),
    "columns of one sensor": (columns([1, 2, 0, 3, 4, 5]), "differ by 120 degrees"),
    "a dead axis": (
        stream("imu", lambda values: np.where(np.arange(6) == 5, 0.1, values)),
        "angular_velocity_z never changes",
    ),
    "no gravity": (stream("imu", without_gravity), "is gravity taken out?"),
    "too short": (between("encoders", lambda t: t < 6.0), "at least 10 s are needed"),
    "a stretch missing": (between("imu", lambda t: (t < 12) | (t > 20)), "no samples for 8.01 s"),
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("use", [process, lambda arm, one: analyse_gears(arm, [one])])
def test_one_error_names_recording_and_fault(recordings, scenes, name, use):
    spoil, said = WRONG[name]
    with pytest.raises(ValueError, match="scene 1: ") as error:
        use(scenes.ARM, spoil(recordings[0]))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("degrees", [30.0, 90.0, 150.0])
def test_sensors_of_one_housing_have_the_same_axes(degrees):
    turned, slightly = (
        Rotation.from_rotvec(np.radians([0.0, 0.0, angle])).as_matrix() for angle in (degrees, 3.0)
    )
    check_pair(np.eye(3), slightly, np.zeros(3))
    with pytest.raises(ValueError, match=f"differ by {degrees:.0f} degrees"):
        check_pair(np.eye(3), turned, np.zeros(3))


def test_a_recording_without_sensor_is_refused(recordings, scenes):
    bare = replace(recordings[0], imu=None, tracker=None)
    with pytest.raises(ValueError, match="imu or tracker"):
        analyse_gears(scenes.ARM, [recordings[0], bare])
    with pytest.raises(ValueError, match="every recording: tracker"):
        analyse_gears(scenes.ARM, [bare], GearsCfg(sensor="tracker"))
    with pytest.raises(ValueError, match="scene 1: the recording has no IMU"):
        process(scenes.ARM, bare)


def test_an_imu_that_missed_the_part_that_is_fitted_is_refused(recordings, scenes):
    with pytest.raises(ValueError, match="the IMU saw 0 % of the first half"):
        process(scenes.ARM, between("imu", lambda t: t > 25.0)(recordings[0]))


def test_a_motor_that_stands_still_is_no_fault_where_the_gyro_agrees(scenes):
    """Motor 3 is held in truth too: its gear is not seen, those of the others are."""
    done = process(scenes.ARM, scenes.recording(scenes.Scene(5, held=2)))
    assert (done.measures.angular_velocity_error < 0.02 * done.measures.angular_velocity).all()


DAMAGES = {
    "columns are missing: angular_velocity_z": lambda text: text.replace("angular_velocity_z", "w"),
    "imu: 60 samples": lambda text: "\n".join(text.split("\n")[:62]) + "\n",
    "no table of numbers": lambda text: "",
    "column .*, row .*: numbers are needed, got .*half": lambda text: text.replace(
        "0.5", "half", 1
    ),
}


@pytest.mark.parametrize("said", DAMAGES)
def test_a_damaged_table_is_named_with_its_folder(tmp_path, recordings, said):
    write_motion_tables(tmp_path, recordings[0], "csv")
    file = tmp_path / "imu.csv"
    file.write_text(DAMAGES[said](file.read_text()))
    with pytest.raises(ValueError, match=f"{tmp_path.name}.*{said}") as error:
        read_motion(tmp_path)
    assert "\n" not in str(error.value)

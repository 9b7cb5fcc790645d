"""A replay read back holds the runs: poses, magnified paths, series, on two timelines."""

from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from rerun.chunk import RrdReader

from armside.assets import LARGE_ROBOT_XML
from armside.kinematics import LARGE_ROBOT, LARGE_ROBOT_LIMITS
from armside.sim.cell import TOOL_QUATERNION, pose
from armside.sim.motion.contour import Circle
from armside.sim.motion.path import CuttingPath, Plane
from armside.sim.motion.tool_motion import plan_cut
from armside.sim.records.signals import RecordedRun
from armside.sim.replay import film
from armside.sim.replay.blueprint import Layout, _robot
from armside.sim.replay.entities import shapes
from armside.sim.replay.offscreen import drawn_model, named_camera, widen
from armside.sim.replay.paths import Contour, fitting_magnification
from armside.sim.replay.scene import Scene, write_scenes
from armside.sim.robot.recording import Recording, Truth

RADIUS = 0.005
MJ = mujoco.MjModel.from_xml_path(str(LARGE_ROBOT_XML))
EVERY_SHAPE = """
<mujoco>
  <asset>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 2 0  0 0 3"/>
    <material name="blue" rgba="0 0 1 1"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="thing" pos="0 0 1">
      <freejoint/>
      <geom type="box" size=".1 .2 .3" pos="1 2 3" quat=".6 .8 0 0" rgba="1 0 0 1"/>
      <geom type="box" size=".1 .1 .1" group="3"/>
      <geom type="box" size=".1 .1 .1" rgba="1 0 0 0"/>
      <geom type="sphere" size=".1" material="blue"/>
      <geom type="ellipsoid" size=".1 .2 .3"/>
      <geom type="cylinder" size=".1 .5"/>
      <geom type="capsule" size=".1 .5" pos="0 0 2"/>
      <geom type="mesh" mesh="wedge" pos="1 0 0" euler="90 0 0"/>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def motion_and_phi():
    path = CuttingPath.around(Circle(RADIUS), Plane(np.array(pose("p1").position)))
    return plan_cut(path, TOOL_QUATERNION, 0.04, LARGE_ROBOT, LARGE_ROBOT_LIMITS)


@pytest.fixture(scope="module")
def runs(motion_and_phi):
    """Rigid runs whose tool cuts the circle too large by 100 um and 20 um, and lies 1 mm off."""
    return [a_run(k, *motion_and_phi, excess) for k, excess in enumerate((100e-6, 20e-6))]


def a_run(k, motion, phi, excess):
    time = np.arange(8 * (len(phi) - 1) + 1) * 5e-4
    angle = np.stack([np.interp(time, motion.time, column) for column in phi.T], axis=1)
    qpos = np.zeros((len(time), MJ.nq))
    for i in range(6):
        qpos[:, MJ.joint(f"motor_{i + 1}").qposadr[0]] = angle[:, i]
    p = motion.position_at(time) - motion.plane.origin
    tool = motion.plane.origin + p * (1 + excess / RADIUS) + [1e-3, 0.0, -1e-3]
    truth = Truth(
        time=time,
        gear_angle=angle,
        **dict.fromkeys(("spring_angle", "motor_torque"), np.zeros_like(angle)),
        **dict.fromkeys(("imu_acceleration", "imu_angular_velocity"), np.zeros_like(tool)),
        tool_position=tool,
        tool_quaternion=np.tile(TOOL_QUATERNION, (len(time), 1)),
        qpos=qpos,
    )
    rng = np.random.default_rng(k)
    recording = Recording(
        time=motion.time,
        reference=phi,
        correction=rng.normal(size=phi.shape),
        motor_angle=phi - 1e-3,
        motor_torque=rng.normal(size=phi.shape),
        truth=truth,
    )
    return RecordedRun(k=k, recording=recording)


def write(path, mj, runs, motion):
    write_scenes(path, [Scene(mj=mj, runs=runs, motion=motion, robot=LARGE_ROBOT)])


@pytest.fixture(scope="module")
def file(tmp_path_factory, motion_and_phi, runs):
    path = tmp_path_factory.mktemp("replay") / "replay.rrd"
    write(path, MJ, runs, motion_and_phi[0])
    return path


def columns(path, entity):
    """Each batch of an entity's changing columns, by the short name of the component."""
    for chunk in RrdReader(path).stream().to_chunks():
        if chunk.entity_path == f"/{entity}" and not chunk.is_static:
            batch = chunk.to_record_batch()
            yield {name.split(":")[-1]: batch.column(name) for name in batch.schema.names}


def values(column):
    return np.array(column.to_pylist(), dtype=np.float64)


def seconds(column):
    return np.array(column.cast("int64").to_pylist()) * 1e-9


def test_the_series_are_those_of_the_runs_on_both_timelines(file, runs):
    for entity, wanted in (
        ("motor_error", lambda r: 1e3 * r.error),
        ("correction", lambda r: 1e3 * r.correction),
        ("motor_torque", lambda r: r.motor_torque),
    ):
        start = 0.0
        batches = list(columns(file, entity))
        assert len(batches) == len(runs)
        for run, batch in zip(runs, batches, strict=True):
            np.testing.assert_array_equal(values(batch["scalars"]), wanted(run.recording))
            np.testing.assert_array_equal(values(batch["iteration"]), run.k)
            in_run = seconds(batch["time"]) - start
            np.testing.assert_allclose(in_run, run.recording.time, rtol=0, atol=2e-9)
            start += run.recording.time[-1] + 0.02


def test_the_deviation_across_the_path_is_the_excess_of_the_radius(file, motion_and_phi):
    motion, _ = motion_and_phi
    for batch, excess in zip(columns(file, "arm_error"), (100.0, 20.0), strict=True):
        tool, motors = values(batch["scalars"]).T
        # um; the static offset of 1 mm is gone. What is left of it and of the end of the contour
        # between two samples is below 1 um.
        np.testing.assert_allclose(tool[motion.on_contour], excess, rtol=0, atol=1.0)
        assert np.isnan(tool[~motion.on_contour]).all()
        assert np.isfinite(motors[motion.on_contour]).all()


def test_the_plane_view_magnifies_the_deviation_and_nothing_else(file):
    # 100 um are enlarged 20 times to 2 mm: 50 times would be as much as the radius, 5 mm.
    for batch, radius in zip(columns(file, "plane/tool"), (5.0 + 2.0, 5.0 + 0.4), strict=True):
        (strip,) = values(batch["strips"])[0]
        np.testing.assert_allclose(np.linalg.norm(strip, axis=1), radius, rtol=0, atol=0.03)
        area = 0.5 * np.sum(strip[:-1, 0] * strip[1:, 1] - strip[1:, 0] * strip[:-1, 1])
        assert area < 0.0  # counter-clockwise with y up is clockwise in picture axes


def test_bodies_are_where_forward_kinematics_puts_them(file, runs):
    (first, _) = columns(file, "robot/disc")
    data = mujoco.MjData(MJ)
    data.qpos[:] = runs[0].recording.truth.qpos[40 * 30]  # a frame is 40 physics steps
    mujoco.mj_kinematics(MJ, data)
    disc = MJ.body("disc").id
    place, turn = values(first["translation"])[30, 0], values(first["quaternion"])[30, 0]
    np.testing.assert_allclose(place, data.xpos[disc], rtol=0, atol=1e-6)  # Rerun keeps float32
    np.testing.assert_allclose(turn, np.roll(data.xquat[disc], -1), rtol=0, atol=1e-6)


def test_it_is_small_and_carries_a_blueprint(file):
    assert file.stat().st_size < 10e6
    assert len(RrdReader(file).blueprints()) == 1
    assert len(RrdReader(file).recordings()) == 1


def test_every_kind_of_visible_geom_is_drawn_once_with_its_place_turn_and_colour():
    drawn = dict(shapes(mujoco.MjModel.from_xml_string(EVERY_SHAPE)))
    kinds = ("box", "sphere", "ellipsoid", "cylinder", "capsule", "mesh_8")
    assert set(drawn) == {"robot/world/plane", *(f"robot/thing/{kind}" for kind in kinds)}
    box, sphere, capsule = (drawn[f"robot/thing/{kind}"] for kind in ("box", "sphere", "capsule"))
    for batch, wanted in (
        (box.centers, [1, 2, 3]),
        (box.half_sizes, [0.1, 0.2, 0.3]),
        (box.quaternions, [0.8, 0.0, 0.0, 0.6]),  # w last
        (box.colors, 0xFF0000FF),
        (sphere.colors, 0x0000FFFF),
        (capsule.translations, [0, 0, 1.5]),  # MuJoCo centres one, Rerun starts it: 2 - 0.5
    ):
        np.testing.assert_allclose(batch.as_arrow_array().to_pylist(), [wanted], rtol=1e-6)


def test_a_mesh_is_drawn_where_the_physics_has_it():
    mj = mujoco.MjModel.from_xml_string(EVERY_SHAPE)
    data = mujoco.MjData(mj)
    data.qpos[:] = [0, 0, 0, 1, 0, 0, 0]  # the body's frame is the world's
    mujoco.mj_kinematics(mj, data)
    geom = mj.ngeom - 1
    expected = mj.mesh_vert @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    mesh = dict(shapes(mj))["robot/thing/mesh_8"]
    found = mesh.vertex_positions.as_arrow_array().to_pylist()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)


def test_a_model_of_another_robot_is_refused(tmp_path, motion_and_phi, runs):
    other = mujoco.MjModel.from_xml_string(EVERY_SHAPE)
    with pytest.raises(ValueError, match="18 joint positions, the model has 7"):
        write(tmp_path / "r.rrd", other, runs, motion_and_phi[0])
    assert list(tmp_path.iterdir()) == []


def test_motors_that_follow_exactly_show_no_deviation_though_the_tool_does(
    tmp_path, motion_and_phi, runs
):
    motion, phi = motion_and_phi
    run = replace(runs[0], recording=replace(runs[0].recording, motor_angle=phi))
    write(tmp_path / "r.rrd", MJ, [run], motion)
    ((batch),) = columns(tmp_path / "r.rrd", "arm_error")
    motors = values(batch["scalars"])[motion.on_contour, 1]
    np.testing.assert_allclose(motors, 0.0, rtol=0, atol=1e-3)


def test_the_camera_is_widened_until_no_shape_is_cut_off_and_no_further():
    mj = drawn_model(MJ, LARGE_ROBOT_XML)
    data, camera = mujoco.MjData(mj), named_camera(mj, "whole")
    i, wide = camera.fixedcamid, 80.0
    mj.cam_fovy[i] = 5.0
    mujoco.mj_forward(mj, data)
    widen(mj, data, camera, 4.0 / 3.0)
    x, y, z = ((data.geom_xpos - data.cam_xpos[i]) @ data.cam_xmat[i].reshape(3, 3)).T
    bodies, half = mj.geom_rbound > 0.0, np.tan(np.radians(0.5 * mj.cam_fovy[i]))
    assert np.abs(x / z)[bodies].max() < 4.0 / 3.0 * half
    assert np.abs(y / z)[bodies].max() < half
    assert 20.0 < mj.cam_fovy[i] < 45.0  # the scene's own is 34, which fits nearly all poses
    mj.cam_fovy[i] = wide
    widen(mj, data, camera, 4.0 / 3.0)
    assert mj.cam_fovy[i] == wide


def test_a_small_round_hole_of_a_part_is_drawn_as_wide_as_high():
    turn = np.linspace(0.0, 2.0 * np.pi, 80)  # 10 mm at 100 mm/s, a point every 4 ms
    circle, outline = np.column_stack([np.cos(turn), np.sin(turn)]), np.array([-0.15, 0.15])
    part = Contour.__new__(Contour)
    part.programmed = np.vstack([0.005 * circle, np.column_stack([outline, outline])])
    part.normal, part.time = np.vstack([circle, circle[:2]]), np.arange(82.0)
    part.cutting, part.tool = np.arange(82) < 80, np.full(82, 1e-4)
    part.pieces, part.between = [slice(0, 41), slice(40, 80)], [slice(80, 82)]
    drawn = np.asarray(film._Panel([part], None).draw("", [(part, part.tool, None, 4)]))
    middle = slice(film.HEIGHT // 2 - 30, film.HEIGHT // 2 + 30)
    ink = 255.0 - drawn[middle, middle, 2]
    at = np.arange(60.0)
    spread = [np.sqrt(np.cov(at, aweights=ink.sum(axis=axis))) for axis in (0, 1)]
    assert spread[0] > 4.0
    assert spread[0] == pytest.approx(spread[1], rel=0.02)


def test_a_film_has_twelve_and_a_half_pictures_in_each_second_of_a_run():
    run = SimpleNamespace(recording=SimpleNamespace(time=np.arange(0.0, 2.001, 0.01)))
    assert film.RATE == 12.5
    np.testing.assert_allclose(film._times(run), 0.08 * np.arange(25), atol=1e-12)  # below 2 s


@pytest.mark.parametrize(
    ("worst", "factor"),
    [(0.015, 50), (0.016, 20), (0.0376, 10), (0.076, 5), (0.151, 2), (0.375, 2), (0.376, 1)],
)
def test_the_largest_magnified_deviation_is_at_most_three_quarters_of_the_half_size(worst, factor):
    contour = SimpleNamespace(is_part=False, worst=worst, half_size=1.0)
    assert fitting_magnification([contour]) == factor


BALL = """
<mujoco>
  <worldbody>
    <camera name="front" pos="0 0 0" fovy="{given}"/>
    <geom type="sphere" size=".1" pos="{x} {y} -2"/>
  </worldbody>
</mujoco>
"""


@pytest.mark.parametrize(
    ("x", "y", "half"),
    # Its edge is at most 0.1 m further out and 0.2 m nearer than its centre; a picture that is
    # twice as wide as high needs half of the angle's tangent across.
    [(1.0, 0.0, 1.1 / 2.0 / 1.9), (0.0, 1.0, 1.1 / 1.9), (0.0, 0.0, 0.0)],
)
def test_a_camera_is_widened_to_the_edge_of_a_ball(x, y, half):
    mj = mujoco.MjModel.from_xml_string(BALL.format(given=5.0, x=x, y=y))
    data, camera = mujoco.MjData(mj), mujoco.MjvCamera()
    mujoco.mj_forward(mj, data)
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    widen(mj, data, camera, aspect=2.0)
    nearest = max(half, 0.1 / 1.9)
    assert mj.cam_fovy[0] == pytest.approx(2.0 * np.degrees(np.arctan(nearest)), rel=1e-9)


def test_the_robot_is_seen_from_a_little_more_than_its_reach_away():
    layout = Layout(
        name="", factor=1.0, target=np.array([2.0, 0.0, 1.0]), height=2.0, worst=100.0, end=1.0,
        is_part=False,
    )  # fmt: skip
    eye = _robot(layout)[0].properties["EyeControls3D"]
    position, middle = (
        np.array(a.as_arrow_array().to_pylist()[0]) for a in (eye.position, eye.look_target)
    )
    np.testing.assert_allclose(middle, [1.0, 0.0, 1.0])
    reach = 2.0 + 2.0
    assert reach < np.linalg.norm(position - middle) < 1.25 * reach
    assert position[1] < 0.0 < position[2] - middle[2]  # from the side and a little above

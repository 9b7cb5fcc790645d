"""Recordings in bags: stamps, joints, frames and topics; and bags that cannot be read."""

import re
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from armside.sim.recordings import BagTopics, MotionRecording, Stream, read_motion
from armside.sim.recordings.bags.bag import joint_order
from armside.sim.recordings.bags.write import write_bag

TIME = np.arange(0.0, 3.0, 0.02)
PHI = np.column_stack([np.sin(TIME), 0.5 * np.cos(0.7 * TIME)])
POINTS = np.column_stack([np.cos(TIME), np.sin(0.3 * TIME), 0.1 * TIME])
FORCE = np.column_stack([np.sin(TIME + k) for k in range(6)])
LATE = 7.0
"""[s] Time of logging after the stamps."""
NAMES = ("joint_2", "joint_1")


def topics(ros, **others):
    """A whole recording; the joints are logged in the other order."""
    angles = zip(TIME, PHI[:, ::-1], strict=True)
    found = {
        "/joint_states": [(t + LATE, ros.joint_state(t, NAMES, phi)) for t, phi in angles],
        "/imu/data": [(t, ros.imu(t, v)) for t, v in zip(TIME, FORCE, strict=True)],
        "/ball": [(t, ros.point(t, p)) for t, p in zip(TIME, POINTS, strict=True)],
    }
    return found | others


@pytest.fixture(scope="module")
def bag(ros, tmp_path_factory):
    return ros.write(tmp_path_factory.mktemp("bags") / "bag", topics(ros))


@pytest.mark.parametrize("form", ["folder", "mcap", "sqlite"])
def test_stamps_of_headers_and_order_of_joints_are_read(ros, bag, tmp_path, form):
    source = bag if form == "folder" else bag / "bag.mcap"
    if form == "sqlite":
        source = ros.write(tmp_path / "old", topics(ros), ros.SQLITE)
    one = read_motion(source)
    assert one.imu is not None
    assert one.tracker is not None
    for stream, values in ((one.encoders, PHI), (one.imu, FORCE), (one.tracker, POINTS)):
        np.testing.assert_allclose(stream.time, TIME, rtol=0.0, atol=1e-9)
        np.testing.assert_array_equal(stream.values, values)
    assert "encoders: /joint_states, joints joint_1, joint_2" in one.notes
    assert "tracker: /ball, frame tracker" in one.notes


def test_the_topic_of_several_is_chosen_by_name(ros, tmp_path):
    more = [
        (t, ros.transform(t, 2.0 * p, child))
        for t, p in zip(TIME, POINTS, strict=True)
        for child in ("tool", "base")
    ]
    source = ros.write(tmp_path / "two", topics(ros, **{"/vicon": more}))
    with pytest.raises(ValueError, match=r"has 2 topics .*/ball, /vicon; .*--tracker-topic"):
        read_motion(source)
    with pytest.raises(ValueError, match="2 frames: base, tool; choose one as /vicon#base"):
        read_motion(source, BagTopics(tracker=("/vicon",)))
    one = read_motion(source, BagTopics(tracker=("/vicon#tool",), imu="none", joints=NAMES))
    assert one.tracker is not None
    np.testing.assert_array_equal(one.tracker.values, 2.0 * POINTS)
    np.testing.assert_array_equal(one.encoders.values, PHI[:, ::-1])
    assert one.imu is None


def stampless(ros):
    return [(t, ros.joint_state(-1.0, NAMES, (0.1, 0.2))) for t in TIME]


def test_what_is_wrong_in_a_bag_is_named(ros, tmp_path):
    other = [(t, ros.point(t, p, f"frame{t > 1.0}")) for t, p in zip(TIME, POINTS, strict=True)]
    deaf = [(t, ros.imu(t, v, lost=True)) for t, v in zip(TIME, FORCE, strict=True)]
    back = [(t, ros.joint_state(3.0 - t, NAMES, (t, t))) for t in TIME]
    bare = [(t, ros.joint_state(t, NAMES, ())) for t in TIME]
    names = [(t, ros.joint_state(t, ("a", "b"), (t, t))) for t in TIME]
    hook = [(t, ros.joint_state(t, (*NAMES, "hook"), (t, t, t))) for t in TIME]
    wrong = {
        "2 frames: frameFalse, frameTrue": {"/ball": other},
        "marks values": {"/imu/data": deaf},
        "clock runs backwards": {"/joint_states": back},
        "150 of 150 messages lack positions": {"/joint_states": bare},
        "no order by name (a, b): give --joints": {"/joint_states": names},
        "no order by name (joint_2, joint_1, hook)": {"/joint_states": hook},
        "no stamps": {"/joint_states": stampless(ros)},
    }
    for number, (said, changed) in enumerate(wrong.items()):
        source = ros.write(tmp_path / f"{number}", topics(ros, **changed))
        with pytest.raises(ValueError, match=re.escape(said)):
            read_motion(source)


def test_topics_that_are_not_there_or_of_another_type_are_named(bag):
    for topics, said in (
        (BagTopics(imu="/other"), "no topic /other"),
        (BagTopics(imu="/ball"), "holds geometry_msgs/msg/PointStamped; --imu-topic takes"),
        (BagTopics(joints=("joint_3",)), "has no joint joint_3. Joints: joint_2, joint_1"),
    ):
        with pytest.raises(ValueError, match=re.escape(said)):
            read_motion(bag, topics)
    with pytest.raises(ValueError, match="x is given twice"):
        BagTopics(tracker=("x", "x"))
    with pytest.raises(ValueError, match="is no bag: topics"):
        read_motion(bag.parent, BagTopics(imu="/imu"))


def test_a_bag_without_encoders_is_refused(ros, tmp_path):
    source = ros.write(tmp_path / "ball", {"/ball": topics(ros)["/ball"]})
    with pytest.raises(ValueError, match=r"no messages of sensor_msgs/msg/JointState.*/ball \(geo"):
        read_motion(source)


def test_damaged_bags_are_named(bag, tmp_path):
    whole = (bag / "bag.mcap").read_bytes()
    contents = {
        "half": whole[: len(whole) // 2],
        "empty": b"",
        "zeros": bytes(5000),
        "flipped": whole[:3000] + bytes(b ^ 255 for b in whole[3000:3200]) + whole[3200:],
    }
    for name, content in contents.items():
        for suffix in (".mcap", ".db3", ".bag"):
            (file := tmp_path / f"{name}{suffix}").write_bytes(content)
            with pytest.raises(ValueError, match=file.name):
                read_motion(file)
    (folder := tmp_path / "folder").mkdir()
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: [1, 2")
    with pytest.raises(ValueError, match="folder"):
        read_motion(folder)


def test_what_is_written_as_a_bag_is_read_as_it_was(tmp_path):
    stamps = TIME - 1.5  # and before zero
    one = MotionRecording(
        name="x", encoders=Stream(stamps, PHI), tracker=Stream(TIME + 4.0, POINTS), form=""
    )
    write_bag(tmp_path / "bag", one)
    back = read_motion(tmp_path / "bag")
    assert back.tracker is not None
    np.testing.assert_array_equal(back.encoders.values, PHI)
    np.testing.assert_array_equal(back.tracker.values, POINTS)
    apart = back.tracker.time - back.encoders.time
    np.testing.assert_allclose(apart, 5.5, rtol=0.0, atol=2e-9)


def test_the_order_of_joints_is_by_number_or_of_universal_robots():
    assert joint_order("/j", ["a10_x", "a2_x", "a1_x"], ()) == ("a1_x", "a2_x", "a10_x")
    listed = sorted(f"ur_{one}_joint" for one in ("wrist_1", "wrist_2", "wrist_3", "elbow"))
    listed += ["ur_shoulder_lift_joint", "ur_shoulder_pan_joint"]
    assert joint_order("/j", listed, ())[:3] == tuple(
        f"ur_{one}_joint" for one in ("shoulder_pan", "shoulder_lift", "elbow")
    )
    for names in (["a", "b"], ["a1", "b2"], ["a1", "a01"], ["a1", "a1"], []):
        with pytest.raises(ValueError, match="give --joints"):
            joint_order("/j", names, ())


def test_a_written_imu_states_that_it_has_no_orientation(tmp_path):
    """sensor_msgs/Imu: -1 as first element of a covariance; zeros say that it is unknown."""
    imu = Stream(TIME, FORCE)
    one = MotionRecording(name="x", encoders=Stream(TIME, PHI), imu=imu, form="")
    write_bag(tmp_path / "bag", one)
    with AnyReader([tmp_path / "bag"]) as bag:
        (topic,) = [each for each in bag.connections if each.topic == "/imu"]
        _, _, raw = next(bag.messages([topic]))
        message: Any = bag.deserialize(raw, topic.msgtype)
    assert message.orientation_covariance.tolist() == [-1.0] + 8 * [0.0]
    assert not message.angular_velocity_covariance.any()
    assert not message.linear_acceleration_covariance.any()

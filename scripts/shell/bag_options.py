"""Options that say what is read from a recording in a ROS bag."""

from dataclasses import dataclass, fields
from typing import Annotated

from cyclopts import Group, Parameter

from armside.sim.recordings.bags import BagTopics

from .help import BAG
from .options import options

_GROUP = Group(BAG, sort_key=6)
_ONE = Parameter(group=_GROUP)
_SEVERAL = Parameter(group=_GROUP, consume_multiple=True, show_default=False)


@options
@dataclass(frozen=True, kw_only=True)
class BagCfg:
    """Topics of a bag. What is not given is found by the types of messages."""

    joint_topic: Annotated[str | None, _ONE] = None
    """Topic of the encoders, sensor_msgs/JointState."""
    imu_topic: Annotated[str | None, _ONE] = None
    """Topic of the IMU, sensor_msgs/Imu; none: do not read it."""
    tracker_topic: Annotated[tuple[str, ...], _SEVERAL] = ()
    """Topics of targets: PoseStamped, PointStamped, TransformStamped or /tf; TOPIC#FRAME for one
    frame of several; none: do not read them."""
    joints: Annotated[tuple[str, ...], _SEVERAL] = ()
    """Names of the joints in the order of the robot's motors [default: by their numbers]."""

    def __post_init__(self) -> None:
        """Raise ValueError for a topic or joint that is given twice."""
        self.topics()

    def topics(self) -> BagTopics:
        """Choice of topics."""
        return BagTopics(
            joint=self.joint_topic,
            imu=self.imu_topic,
            tracker=self.tracker_topic,
            joints=self.joints,
        )


BAG_FIELDS = frozenset(field.name for field in fields(BagCfg))
"""Names of these options' fields."""

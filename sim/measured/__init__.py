"""Measurements of real arms: files as their authors published them, and one form for any arm."""

from .bags import BagTopics as BagTopics
from .motion import MotionRecording as MotionRecording
from .motion import Stream as Stream
from .motion_source import is_motion as is_motion
from .motion_source import read_motion as read_motion
from .pose_source import PoseSource as PoseSource
from .pose_source import read_poses as read_poses

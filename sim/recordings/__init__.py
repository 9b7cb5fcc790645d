"""Measurements of real arms: files as their authors published them, and one form for any arm."""

from .bags import BagTopics as BagTopics
from .read import is_motion as is_motion
from .read import read_motion as read_motion
from .read import read_poses as read_poses
from .recorded_motion import MotionRecording as MotionRecording
from .recorded_motion import PoseRecording as PoseRecording
from .recorded_motion import Stream as Stream

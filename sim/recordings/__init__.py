"""Measurements of real arms: files as their authors published them, and one form for any arm."""

from .bags import BagTopics as BagTopics
from .read import is_motion as is_motion
from .read import read_motion as read_motion
from .read import read_poses as read_poses
from .recording import MotionRecording as MotionRecording
from .recording import PoseRecording as PoseRecording
from .recording import Stream as Stream

from .bags.messages import BagTopics as BagTopics
from .read import is_motion as is_motion
from .read import read_motion as read_motion
from .read import read_poses as read_poses
from .recorded_motion import MotionRecording as MotionRecording
from .recorded_motion import PoseRecording as PoseRecording
from .recorded_motion import Stream as Stream

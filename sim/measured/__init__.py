"""Measurements of real arms: files as their authors published them, and one form for any arm."""

from .pose_source import PoseSource as PoseSource
from .pose_source import read_poses as read_poses

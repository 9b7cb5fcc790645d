"""Instruments: functions of recorded arrays, from the ideal reading to the sample.

Ideal reading -> bandwidth -> bias -> noise -> range -> quantisation -> sampling. SI units,
quaternions w first; every random draw comes from a Generator that the caller passes in.
"""

from .imu import Imu as Imu
from .imu import ImuCfg as ImuCfg
from .imu import ImuSamples as ImuSamples
from .laser_tracker import LaserTracker as LaserTracker
from .laser_tracker import LaserTrackerCfg as LaserTrackerCfg
from .laser_tracker import TrackerSamples as TrackerSamples
from .laser_tracker import set_up as set_up

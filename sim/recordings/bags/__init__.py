"""Recordings in ROS 2 bags (MCAP, SQLite), MCAP files of ROS 2 messages, and ROS 1 bags.

sensor_msgs/JointState are the encoders, sensor_msgs/Imu the IMU, and PoseStamped, PointStamped or
TransformStamped of geometry_msgs (or one frame of /tf) a point of a tracker or of cameras. Stamps
are those of the messages' headers; neither the time of logging nor the order in the file counts.
"""

from .messages import BagTopics as BagTopics

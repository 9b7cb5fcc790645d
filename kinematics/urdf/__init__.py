"""URDF files as Denavit-Hartenberg robots: elements, the chain from base to tip, its table."""

from .reader import UrdfArm as UrdfArm
from .reader import read_urdf as read_urdf

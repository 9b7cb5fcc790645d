"""From logged motor angles and IMU samples to signals that can be compared. Thesis chapter 5.

Functions of arrays: synchronise the clocks, predict what the IMU should read from the motor angles,
compensate the measurement for gravity and offsets, rotate it to base axes, filter both sides alike.
SI units; accelerations in base axes are without gravity.
"""

from .compare import Comparison as Comparison
from .compare import Compensation as Compensation
from .compare import ProcessingCfg as ProcessingCfg
from .compare import compare as compare
from .compare import moving_rms as moving_rms
from .differences import Scheme as Scheme
from .prediction import Order as Order
from .prediction import predict as predict
from .synchronise import clock_offset as clock_offset

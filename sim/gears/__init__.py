"""Transmission error of the gears of a real arm, from its encoders and a sensor at its tool.

The tool's motion by the encoders is compared with that of an IMU, or of a tracker, in a band of
frequency. What a joint's error epsilon(phi) = a sin(order phi) + b cos(order phi), output minus
motor angle, would add to the sensor follows from the Jacobian of the arm; amplitudes, phases and
orders are found by least squares in the frequency domain, each frequency weighted by its noise.
"""

from .analysis import VIRTUAL as VIRTUAL
from .analysis import Coverage as Coverage
from .analysis import GearAnalysis as GearAnalysis
from .analysis import GearsCfg as GearsCfg
from .analysis import Judgement as Judgement
from .analysis import analyse_gears as analyse_gears
from .analysis import coverage as coverage
from .analysis import coverage_notes as coverage_notes
from .judgement import Remaining as Remaining
from .transmission import Transmission as Transmission

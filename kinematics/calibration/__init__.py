"""Calibration of a serial arm from poses that a tracker or cameras measured.

Lengths in metres, angles in radians. Errors are those of the Denavit-Hartenberg table, of base and
tool, and of single joints; the identification Jacobian comes from the symbolic toolbox.
"""

from .calibrate import Calibration as Calibration
from .calibrate import CalibrationCfg as CalibrationCfg
from .calibrate import calibrate as calibrate
from .calibrate import fit_prepared as fit_prepared
from .calibrate import prepare as prepare
from .error_model import ErrorModel as ErrorModel
from .fit import Choice as Choice
from .fit import Fit as Fit
from .fit import Priors as Priors
from .fit import fit as fit
from .joint_errors import JointErrors as JointErrors
from .measurements import Measurements as Measurements
from .selection import identifiable as identifiable
from .selection import next_poses as next_poses

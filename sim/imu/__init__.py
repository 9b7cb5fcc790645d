"""An IMU on a moving robot: measured against predicted motion. Thesis chapter 5.

`run_imu(ImuExperiment(), seed=0)` moves the virtual robot with an IMU on its tool and predicts what
the IMU measures from logged motor angles alone. The steps are functions of arrays of their own:
synchronise the clocks, predict, compensate for gravity and offsets, filter both sides alike.
`recorded.process` does the same with a recording of a real robot, whose constants it finds.
SI units; vectors in base axes, accelerations without gravity.
"""

from .compare import ImuComparison as ImuComparison
from .compare import clock_offset as clock_offset
from .compare import compare as compare
from .compare import moving_rms as moving_rms
from .evaluation import Evaluation as Evaluation
from .evaluation import Measures as Measures
from .experiment import ImuResult as ImuResult
from .experiment import causes as causes
from .experiment import clock_errors as clock_errors
from .experiment import notes as notes
from .experiment import prepare as prepare
from .experiment import reprocessed as reprocessed
from .experiment import results as results
from .experiment import run_imu as run_imu
from .experiment import run_one as run_one
from .prediction import Compensation as Compensation
from .prediction import Order as Order
from .prediction import ProcessingCfg as ProcessingCfg
from .prediction import Scheme as Scheme
from .prediction import predict as predict
from .specification import ImuExperiment as ImuExperiment
from .specification import RestExperiment as RestExperiment
from .vibration import run_rest as run_rest

"""An IMU on a moving robot: measured against predicted motion. Thesis chapter 5.

`run_imu(ImuExperiment(), seed=0)` moves the virtual robot with an IMU on its tool and predicts what
the IMU measures from logged motor angles alone. The steps are functions of arrays of their own:
synchronise the clocks, predict, compensate for gravity and offsets, filter both sides alike.
`recorded.process` does the same with a recording of a real robot, whose constants it finds.
SI units; vectors in base axes, accelerations without gravity.
"""

from .imu_experiment import ImuResult as ImuResult
from .imu_experiment import causes as causes
from .imu_experiment import clock_errors as clock_errors
from .imu_experiment import notes as notes
from .imu_experiment import prepare as prepare
from .imu_experiment import reprocessed as reprocessed
from .imu_experiment import results as results
from .imu_experiment import run_imu as run_imu
from .imu_experiment import run_one as run_one
from .imu_specification import ImuExperiment as ImuExperiment
from .imu_specification import RestExperiment as RestExperiment
from .measured_beside_predicted import ImuComparison as ImuComparison
from .measured_beside_predicted import clock_offset as clock_offset
from .measured_beside_predicted import compare as compare
from .measured_beside_predicted import moving_rms as moving_rms
from .phases import Evaluation as Evaluation
from .phases import Measures as Measures
from .predicted_motion import Compensation as Compensation
from .predicted_motion import Order as Order
from .predicted_motion import ProcessingCfg as ProcessingCfg
from .predicted_motion import Scheme as Scheme
from .predicted_motion import predict as predict
from .vibration import run_rest as run_rest

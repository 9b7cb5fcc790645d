"""Learning laws: small objects that map (u_k, e_k) to u_{k+1}.

First-order laws are functions `law(u, e)`; every law has `step(u, e, memory)`, which returns the
next correction and the next memory. Filters L and Q are objects of their own.
"""

from .adaptive import Adaptive as Adaptive
from .constrained import Constrained as Constrained
from .disturbance_observer import DisturbanceObserver as DisturbanceObserver
from .finite_difference import FiniteDifference as FiniteDifference
from .gains import DType as DType
from .gains import MatrixGain as MatrixGain
from .gains import PType as PType
from .gradient import Gradient as Gradient
from .heuristic import Heuristic as Heuristic
from .high_order import HighOrder as HighOrder
from .internal_model import internal_model as internal_model
from .internal_model import periodic_pattern as periodic_pattern
from .law import FirstOrder as FirstOrder
from .law import FirstOrderLaw as FirstOrderLaw
from .law import Law as Law
from .model_free import MeasuredGradient as MeasuredGradient
from .model_inverse import ModelInverse as ModelInverse
from .norm_optimal import NormOptimal as NormOptimal
from .quadratic import QuadraticCriterion as QuadraticCriterion
from .scheduled import Scheduled as Scheduled
from .simulated import Simulated as Simulated
from .time_varying import Blend as Blend

"""Learning laws: small objects that map (u_k, e_k) to u_{k+1}.

First-order laws are functions `law(u, e)`; every law has `step(u, e, memory)`, which returns the
next correction and the next memory. Filters L and Q are objects of their own.
"""

from .first_order import Blend as Blend
from .first_order import DType as DType
from .first_order import FirstOrder as FirstOrder
from .first_order import FirstOrderLaw as FirstOrderLaw
from .first_order import Law as Law
from .first_order import MatrixGain as MatrixGain
from .first_order import PType as PType
from .heuristic import Heuristic as Heuristic
from .memory import Adaptive as Adaptive
from .memory import DisturbanceObserver as DisturbanceObserver
from .memory import HighOrder as HighOrder
from .memory import internal_model as internal_model
from .memory import periodic_pattern as periodic_pattern
from .model_based import Gradient as Gradient
from .model_based import ModelInverse as ModelInverse
from .model_free import FiniteDifference as FiniteDifference
from .model_free import MeasuredGradient as MeasuredGradient
from .norm_optimal import Constrained as Constrained
from .norm_optimal import NormOptimal as NormOptimal
from .quadratic import QuadraticCriterion as QuadraticCriterion
from .wrappers import Scheduled as Scheduled
from .wrappers import Simulated as Simulated

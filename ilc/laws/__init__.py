"""Learning laws, each a small object that maps (u_k, e_k) to u_{k+1}."""

from .heuristic import Heuristic as Heuristic
from .law import FirstOrderLaw as FirstOrderLaw
from .law import Law as Law

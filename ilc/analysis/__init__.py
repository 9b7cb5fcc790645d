"""Convergence analysis of a learning law: criterion, asymptotic error, finite records, design."""

from .criterion import Criterion as Criterion
from .criterion import asymptotic_error as asymptotic_error
from .criterion import criterion as criterion
from .criterion import frequency_grid as frequency_grid
from .criterion import hertz as hertz
from .criterion import heuristic_criterion as heuristic_criterion
from .eigenloci import Eigenloci as Eigenloci
from .eigenloci import eigenloci as eigenloci
from .limits import largest_cutoff as largest_cutoff
from .limits import largest_gamma as largest_gamma
from .record_iteration import LiftedIteration as LiftedIteration

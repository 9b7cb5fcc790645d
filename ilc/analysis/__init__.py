"""Convergence analysis of a learning law: criterion, asymptotic error, finite records, design."""

from .asymptotic import asymptotic_error as asymptotic_error
from .criterion import Criterion as Criterion
from .criterion import criterion as criterion
from .criterion import frequency_grid as frequency_grid
from .criterion import hertz as hertz
from .criterion import heuristic_criterion as heuristic_criterion
from .criterion import largest_cutoff as largest_cutoff
from .criterion import largest_gamma as largest_gamma
from .lifted import LiftedIteration as LiftedIteration

"""One cut learned in several ways, each with its beginning and the state that it can go on from."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from armside.arrays import Array
from armside.ilc.workbench.state import RunState

from .comparison import COMPARED, Case
from .experiment import Experiment, Iteration
from .learning import Begin
from .resume import state_after
from .tool_measure import Source, ToolPath

WAYS = ("motor", "estimate", "tracker", "oracle")
"""Measured outputs; each may have a beginning of its own in `compared`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """Iterations of one measured output, the first run among them."""

    iterations: list[Iteration]
    state: RunState = field(repr=False)

    @classmethod
    def of(cls, iterations: list[Iteration], experiment: Experiment, start: Array | None) -> "Way":
        """The state is read from the plant of the experiment after its last run."""
        loop = iterations[-1].state
        assert loop is not None, "iterations of a loop"
        return cls(iterations=iterations, state=state_after(loop, experiment.plant, start))


def compared(
    case: Case,
    iterations: int,
    measure: ToolPath = COMPARED,
    begins: Mapping[str, Begin] | None = None,
) -> dict[str, Way]:
    """Learned from each of `WAYS`; one identification, by the estimate's first run, serves all.

    begins: by way, for those that do not begin without correction.

    Raises InputError where a loop to go on from is another one's.
    """
    begin = {name: (begins or {}).get(name, Begin()) for name in WAYS}
    experiment = case.experiment()
    motor = list(case.from_motors(iterations, experiment=experiment, begin=begin["motor"]))
    found = {"motor": Way.of(motor, experiment, begin["motor"].first_correction)}
    parameters = None
    for source, name in zip((Source.ESTIMATE, Source.TRACKER, Source.TRUTH), WAYS[1:], strict=True):
        experiment, chosen = case.experiment(), replace(measure, source=source)
        how = {"experiment": experiment, "begin": begin[name]}
        output, learning = case.from_tool(iterations, chosen, parameters, **how)
        found[name] = Way.of(list(learning), experiment, begin[name].first_correction)
        parameters = output.known.parameters if parameters is None else parameters
    return found

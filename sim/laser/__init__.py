"""The laser cutting experiment: a robot cuts a contour or a part and learns to cut it better.

```python
from armside.sim.laser import Cut, learn

for iteration in learn(Cut(pose="p3", radius=0.005, speed=0.040), measure="estimate", seed=0):
    print(iteration.k, iteration.tool.rms)
```

A law, a measure or a plant of one's own is one argument of `learn`. A part with many contours is a
`part_cut.PartCut` in place of the `Cut`. SI units.
"""

from typing import TYPE_CHECKING, Any

from .design import THESIS as THESIS
from .design import Design as Design
from .experiment import Experiment as Experiment
from .experiment import Iteration as Iteration
from .experiment import Pass as Pass
from .experiment import prepare as prepare
from .learning import iterate as iterate
from .learning import learn as learn
from .measures import Measure as Measure
from .measures import MotorAngles as MotorAngles
from .measures import Output as Output
from .specification import Cut as Cut
from .specification import LeadIn as LeadIn

if TYPE_CHECKING:
    from .tool_measure import Source as Source
    from .tool_measure import ToolPath as ToolPath


def __getattr__(name: str) -> Any:
    """Measures of the tool, whose estimator is loaded when it is used."""
    if name in ("Source", "ToolPath"):
        from . import tool_measure

        return getattr(tool_measure, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

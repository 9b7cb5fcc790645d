"""The virtual robot behind the protocol of a controller, and the plants on the other side.

`VirtualController` runs the robot cycle by cycle; `armside.sim.controller.server` carries its
messages by ABB's EGM or KUKA's RSI over UDP. `StreamedPlant` is the client: a plant that a law
learns on, in this process (`InProcess`), or on any controller that speaks one of the protocols.
`stored_correction` is what a run has learned, `correction_export` writes it for a controller.

Names are loaded when they are used, as stored corrections need no robot.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .client import Connection as Connection
    from .client import Egm as Egm
    from .client import Rsi as Rsi
    from .controller import Hold as Hold
    from .controller import VirtualController as VirtualController
    from .limits import GuidanceLimits as GuidanceLimits
    from .messages import Answer as Answer
    from .messages import Phase as Phase
    from .messages import State as State
    from .plant import InProcess as InProcess
    from .plant import StreamedPlant as StreamedPlant

_HOMES = {
    "client": ("Egm", "Connection", "Rsi"),
    "controller": ("Hold", "VirtualController"),
    "limits": ("GuidanceLimits",),
    "messages": ("Answer", "Phase", "State"),
    "plant": ("InProcess", "StreamedPlant"),
}


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f".{module}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

"""The virtual robot behind the protocol of a controller, and the plants on the other side.

`VirtualController` runs the robot cycle by cycle; `armside.sim.controller.server` carries its
messages by ABB's EGM or KUKA's RSI over UDP. `StreamedPlant` is the client: a plant that a law
learns on, in this process (`InProcess`), or on any controller that speaks one of the protocols.
"""

from .client import Egm, Link, Rsi
from .controller import Hold, VirtualController
from .limits import GuidanceLimits
from .messages import Answer, Phase, State
from .plant import InProcess, StreamedPlant

__all__ = [
    "Answer",
    "Egm",
    "GuidanceLimits",
    "Hold",
    "InProcess",
    "Link",
    "Phase",
    "Rsi",
    "State",
    "StreamedPlant",
    "VirtualController",
]

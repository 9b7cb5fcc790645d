"""The virtual robot behind the protocol of a controller, and the plants on the other side.

`VirtualController` runs the robot cycle by cycle; `armside.sim.controller.server` carries its
messages by ABB's EGM or KUKA's RSI over UDP. `StreamedPlant` is the client: a plant that a law
learns on, in this process (`InProcess`), or on any controller that speaks one of the protocols.
`stored_correction` is what a run has learned, `correction_export` writes it for a controller.

Names are loaded when they are used, as stored corrections need no robot.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

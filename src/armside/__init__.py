"""A MuJoCo testbed for iterative learning control of industrial robots.

- `armside.kinematics`: Denavit-Hartenberg robots, symbolic and compiled.
- `armside.ilc`: learning laws, filters, analysis, estimation.
- `armside.sim`: virtual hardware, and the experiments that run on it.
- `armside.assets`: MJCF models of the robots.
- `armside.scripts`: the command `armside`.

The names that stay are those of the stubs `__init__.pyi` here and in the packages, each loaded when
it is used. SI units and radians, unless a name says otherwise.
"""

import lazy_loader

from .gymnasium_hook import register_env

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

register_env()

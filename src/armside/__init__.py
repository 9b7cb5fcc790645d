"""A MuJoCo testbed for iterative learning control of industrial robots.

- `armside.kinematics`: Denavit-Hartenberg robots, symbolic and compiled.
- `armside.ilc`: learning laws, filters, analysis, estimation.
- `armside.sim`: virtual hardware, and the experiments that run on it.
- `armside.assets`: MJCF models of the robots.
- `armside.scripts`: the command `armside`.

SI units and radians, unless a name says otherwise.
"""

from .gymnasium_hook import register_env

register_env()

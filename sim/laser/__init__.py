"""The laser cutting experiment: a robot cuts a contour or a part and learns to cut it better.

```python
from armside import Cut, learn

for iteration in learn(Cut(pose="p3", radius=0.005, speed=0.040), measure="estimate", seed=0):
    print(iteration.k, iteration.tool.rms)
```

A law, a measure or a plant of one's own is one argument of `learn`. A part with many contours is a
`PartCut` in place of the `Cut`. SI units.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

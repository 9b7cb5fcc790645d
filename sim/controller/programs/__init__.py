"""Programs of industrial robots: RAPID (`.mod`), KRL (`.src` with `.dat`), URScript (`.script`).

`read_program_file` gives the moves as `armside.sim.motion.instructions`, in SI units, each with the
place of its numbers in the text. `rows_of` has the path of the linear ones, `corrected` a
text in which numbers alone are new. Quaternions are w first.

Conventions of the makers: RAPID mm, quaternion (w, x, y, z); KRL mm and degrees, R = Rz(A) Ry(B)
Rx(C); URScript m and rad, rotation vector.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

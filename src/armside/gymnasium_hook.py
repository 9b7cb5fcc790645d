"""Registration of the env with Gymnasium, whichever of the two is imported first.

Gymnasium costs a tenth of a second that the command line does not have, so it is never imported
from here: where it is not loaded yet, an import hook waits for it.
"""

import sys
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import find_spec
from types import ModuleType


def register_env() -> None:
    """Register `armside/IlcTuning-v0` and `-v1` now, or as soon as Gymnasium has been imported."""
    if "gymnasium" in sys.modules:
        from .sim.tuning import registration as registration
    else:
        sys.meta_path.insert(0, _Waiting())


class _Loading(SourceFileLoader):
    def exec_module(self, module: ModuleType) -> None:
        super().exec_module(module)
        register_env()


class _Waiting(MetaPathFinder):
    def find_spec(
        self, fullname: str, path: object = None, target: object = None
    ) -> ModuleSpec | None:
        if fullname != "gymnasium":
            return None
        sys.meta_path.remove(self)
        spec = find_spec(fullname)
        if spec is not None and spec.origin is not None:
            spec.loader = _Loading(fullname, spec.origin)
        return spec

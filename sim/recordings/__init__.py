"""Measurements of real arms: files as their authors published them, and one form for any arm."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

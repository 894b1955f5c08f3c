"""Motions: circles with lead-in and lead-out, excitations of the joints; moves, curves and time laws for any other."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

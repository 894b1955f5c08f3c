"""Motions from files and names (path descriptions, tables, RAPID programs) as references for a robot."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

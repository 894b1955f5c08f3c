"""Motions: curves, moves, time laws, references; in `motions` motion files, in `rapid` RAPID programs.

The arm that follows them stands in `ffgym.robot`, lists of motions to record in `ffgym.simulation.protocols`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

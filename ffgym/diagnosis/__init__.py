"""Errors of a simulation, their causes and how sure they are; in `identification` parameters from recordings.

Reading and judging logs stands in `ffgym.logs`, the gain in control in `ffgym.improvement`, exams in `scripts.exam`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

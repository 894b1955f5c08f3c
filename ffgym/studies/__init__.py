"""Experiments of the thesis and of any motion: what is run and how it is scored.

Figures and claims of the thesis stand in `scripts.thesis`, tables and pages in `ffgym.report`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Experiments of the thesis and of any motion: runs and scores.

Figures and claims of the thesis are in `scripts.thesis`, tables and pages in `ffgym.report`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Logs of other tools as recordings: formats, column maps; in `preparation` sides and filters, in `quality` the gate.

The project's own file format stands in `ffgym.recordings`, causes of what a log shows in `ffgym.diagnosis`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

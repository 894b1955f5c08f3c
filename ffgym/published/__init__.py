"""Numbers that others published, as data.

What is made of them stands in `ffgym.report` and `scripts.thesis`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

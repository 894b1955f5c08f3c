"""Recordings of one motion, simulated or measured: schema, reader, writer; in `metrics` figures of merit.

Logs of other tools and the quality of a recording are in `ffgym.logs`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

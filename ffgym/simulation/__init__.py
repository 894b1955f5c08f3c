"""Plant, controller and path in one run, and sensors; in `protocols` what to record, in `export` files for MuJoCo.

Laws stand in `ffgym.control`, motions in `ffgym.paths`, environments in `ffgym.envs`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

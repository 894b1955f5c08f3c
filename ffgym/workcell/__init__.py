"""A stand-in for a real robot: machines with a hidden truth, in equations of their own.

Only `ffgym.envs`, `scripts` and `tests` import it, so that methods know of it what they measure; effects that a
diagnosis knows stand in `ffgym.effects`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

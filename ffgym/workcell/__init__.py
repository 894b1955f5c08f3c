"""Workcells that stand in for real robots: machines with hidden parameters and equations of their own.

Only `ffgym.envs`, `scripts` and `tests` import this package, so that methods know a workcell by its measurements alone.
The effects that a diagnosis knows are in `ffgym.effects`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

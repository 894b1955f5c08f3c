"""The workcell: what stands for a real robot, with a truth that only environments and tests come near.

Nothing but `ffgym.envs`, `scripts` and `tests` may import it, so that methods know of it what they measure.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Laws of a controller: rigid feed-forward, friction laws, servo, set-points, the layout of observations.

Laws that learn or are solved along a reference are in `ffgym.agents`, references in `ffgym.paths`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""What a robot description amounts to: reach, loads, margins, resonances, servo, and numbers that are hardly true."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

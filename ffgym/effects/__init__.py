"""Physical effects that a machine may have and its nominal model may lack, one file each.

Plain LuGre friction stands in `ffgym.robot.friction`, their use in a plant in `ffgym.simulation`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

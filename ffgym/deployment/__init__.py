"""Laws on their way to a controller: set-points, corrected programs, streams, emulators, code, trials on a machine.

The set-point channel is in `ffgym.control`, files for plain MuJoCo in `ffgym.simulation.export`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

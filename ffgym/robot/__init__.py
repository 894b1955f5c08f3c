"""Robots: descriptions with the origin of every number, arm files, models, kinematics, dynamics, friction.

The simulation of a model stands in `ffgym.simulation`, what a machine has beyond its model in `ffgym.effects`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

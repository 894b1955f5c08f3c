"""Robots: descriptions with the origin of every number, their MuJoCo models, kinematics and rigid dynamics."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

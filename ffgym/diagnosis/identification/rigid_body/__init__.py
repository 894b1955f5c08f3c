"""Rigid-body identification: inertial parameters that exist, rotors, friction and offsets, from recorded torque."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

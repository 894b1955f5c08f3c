"""Plans sent to controllers in real time: ABB EGM, KUKA RSI, UR RTDE, ROS 2, one safety envelope, and emulators."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

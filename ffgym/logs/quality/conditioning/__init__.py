"""Conditioning: what a log needs before filters and checks, each step told in its header, nothing else changed."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

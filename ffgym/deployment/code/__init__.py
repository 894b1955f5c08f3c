"""Code for machines without Python: laws in C99, tables, policies as ONNX, robots and programs as FMUs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

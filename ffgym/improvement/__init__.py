"""What a diagnosis gains in control: record, diagnose, extend the model, compensate with it, again."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

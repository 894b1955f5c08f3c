"""Patterns of residuals without a model: functions of a variable, periods, spectral lines, any dependence."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

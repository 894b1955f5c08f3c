"""Claims: passages of pages as they follow from stored results, records and the code, a module for each field."""

from importlib import import_module
from pkgutil import iter_modules

for _field in iter_modules(__path__):
    import_module(f"{__name__}.{_field.name}")

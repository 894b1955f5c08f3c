"""Whoever gives a yes or no to a fit says what of: `fit(problem, causes, begun=True)`."""

import importlib
import inspect
import pkgutil

import pytest

from ffgym.diagnosis import fit

MODULES = [importlib.import_module(f"{fit.__name__}.{module.name}") for module in pkgutil.iter_modules(fit.__path__)]


def functions(module):
    """Functions of a module, and methods of its classes."""
    for _, own in inspect.getmembers(module, lambda each: getattr(each, "__module__", None) == module.__name__):
        if inspect.isfunction(own):
            yield own
        elif inspect.isclass(own):
            yield from (each for name, each in vars(own).items() if inspect.isfunction(each) and name[:2] != "__")


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.rpartition(".")[2])
def test_flags_are_given_by_their_names(module):
    for function in functions(module):
        for parameter in inspect.signature(function).parameters.values():
            if parameter.annotation is bool:
                assert parameter.kind is inspect.Parameter.KEYWORD_ONLY, (function.__qualname__, parameter.name)

"""Inputs and outputs of the controller, as far as a program sees them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ffgym.core.errors import FFGymError, check_number


@dataclass
class ControllerSignals:
    """Values of signals: given ones, those that the program sets, and those that it has waited for.

    A signal of which nothing is known has the value 0, and is listed in `assumed`.
    """

    values: dict[str, float] = field(default_factory=dict)
    """By name in lower case."""
    assumed: dict[str, str] = field(default_factory=dict)
    """Names of signals whose value was assumed, as written, by name in lower case."""

    def ask(self, name: str) -> float:
        """Value of an input."""
        if name.lower() not in self.values:
            self.assumed.setdefault(name.lower(), name)
        return self.output(name)

    def output(self, name: str) -> float:
        """Value of an output, which is 0 until the program sets it."""
        return self.values.get(name.lower(), 0.0)

    def set(self, name: str, value: float) -> None:
        """Set a signal, or know its value because the program waited for it."""
        self.values[name.lower()] = value

    def notes(self) -> list[str]:
        """Note the signals whose value was assumed."""
        if not self.assumed:
            return []
        return [f"taken as 0, because no value was given (inputs): {', '.join(sorted(self.assumed.values()))}"]


def read_inputs(inputs: Mapping[str, float] | None) -> ControllerSignals:
    """ControllerSignals with given values.

    Raises:
        FFGymError: if a value is no number.
    """
    values: dict[str, float] = {}
    for name, value in (inputs or {}).items():
        if name.lower() in values:
            raise FFGymError(f"input {name} is given twice, in upper and lower case.")
        values[name.lower()] = check_number(f"input {name}", float(value) if isinstance(value, bool) else value)
    return ControllerSignals(values=values)

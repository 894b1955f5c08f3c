"""Parameters of physical effects: unit, value at which the effect vanishes, plausible range, source."""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array

_KEY = "effect_parameter"

Per = Literal["joint", "pair", "machine", "vector"]
"""One number per joint (N,), per pair of joints (N, N), for the machine (), or three of a vector (3,)."""


Scale = Literal["", "top_speed"]
"""Quantity of the robot that a shape equals: nothing, or the largest speed of each motor [rad/s], as a unit for
sizes."""


Role = Literal["size", "phase", "cycles", "span", "shape"]
"""Role of a parameter in a search: size of the effect; phase of a wave, and number of its periods; span, a shape in
which the effect is (nearly) linear, so that two values span all; or any other shape."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """Declaration of a parameter: meaning, unit, and knowledge before any measurement."""

    name: str = ""
    meaning: str
    """One phrase, with the side where there are two."""
    unit: str
    """SI; '1' for a pure number."""
    null: float | None = 0.0
    """Value at which the effect vanishes; None for a parameter of shape, e.g. a phase, which then does not matter."""
    low: float
    """Lower end of what is plausible on an industrial robot."""
    high: float
    """Upper end."""
    source: str
    """Source of the range."""
    per: Per = "joint"
    """Entity that has one number each."""
    minimum: float = -np.inf
    """Smallest value that makes sense."""
    maximum: float = np.inf
    """Largest value that makes sense."""
    role: Role | None = None
    """Role in a search among effects; None stands for a size if there is a null value, else for a shape."""
    tries: tuple[float, ...] = ()
    """Values of a shape at which a search begins; if empty, it begins at the default value. For cycles they serve
    joints that move too little to show a period; if empty, the search begins at the periods that residuals show."""
    default: float | None = None
    """Value if none is given; None if one must be."""
    scale: Scale = ""
    """Quantity of the robot that is the default value: such a parameter is only the unit of a size, and is not
    fitted."""
    of: tuple[str, str] | None = None
    """Part and number of the description that it changes by a share; None if it changes no number."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "role", self.role or ("shape" if self.null is None else "size"))

    @property
    def is_looked_for(self) -> bool:
        """True for a frequency that is looked for in residuals."""
        return self.role == "cycles" and not self.tries

    @property
    def neutral(self) -> float:
        """Value for a joint that the effect leaves alone."""
        return self.low if self.null is None else self.null

    def shape(self, n_joints: int) -> tuple[int, ...]:
        """Shape on a robot of N joints."""
        shapes: dict[str, tuple[int, ...]] = {
            "joint": (n_joints,),
            "pair": (n_joints, n_joints),
            "machine": (),
            "vector": (3,),
        }
        return shapes[self.per]

    def numbers(self, owner: str, value: Any) -> Array:
        """Return `value` as an array of any shape.

        Raises:
            FFGymError: if it is not made of numbers, or of rows of different length.
        """
        try:
            array = np.asarray(value)
        except ValueError as error:
            raise FFGymError(f"{owner}.{self.name} has rows of different length: {value!r}.") from error
        if array.dtype.kind not in "iuf":
            raise FFGymError(f"{owner}.{self.name} must be numbers, got {value!r}.")
        return array.astype(np.float64)

    def validate(self, owner: str, value: Any, n_joints: int) -> Array:
        """Return `value` as an array of the right shape; one number stands for all joints.

        Raises:
            FFGymError: if it has another shape, is not finite, or is below or above what makes sense.
        """
        shape, name = self.shape(n_joints), f"{owner}.{self.name}"
        array = self.numbers(owner, value)
        array = check_shape(name, array if array.ndim else np.full(shape, array), shape)
        unit = "" if self.unit == "1" else f" {self.unit}"
        if np.any(array < self.minimum):
            raise FFGymError(f"{name} = {array.tolist()}{unit} must be at least {self.minimum:g}{unit}.")
        if np.any(array > self.maximum):
            raise FFGymError(f"{name} = {array.tolist()}{unit} must be at most {self.maximum:g}{unit}.")
        return array


def parameter(meaning: str, **known: Any) -> Any:
    """Declare a field of an effect's dataclass as a parameter; keyword arguments are the fields of `Parameter`."""
    found = Parameter(meaning=meaning, **known)
    if found.default is None:
        return field(metadata={_KEY: found})
    return field(default=np.float64(found.default), metadata={_KEY: found})  # `validate` spreads it over the joints


def declaration_in(metadata: Any) -> Parameter | None:
    """Return the parameter that a dataclass field declares, if any; its name is still empty."""
    found = metadata.get(_KEY)
    return found if isinstance(found, Parameter) else None

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
"""What of a robot a shape is: nothing, or the largest speed of each motor [rad/s], by which others count."""


Role = Literal["size", "phase", "cycles", "span", "shape"]
"""What a parameter is to a search: how large the effect is; the phase of something periodic, and how often it repeats;
a shape in which the effect is linear (or nearly), so that two values span all; or anything else that gives it its
shape."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """What is known of a parameter before any measurement."""

    name: str
    meaning: str
    """One phrase, with the side where there are two."""
    unit: str
    """SI; '1' for a pure number."""
    null: float | None
    """Value at which the effect vanishes; None for a parameter of shape, e.g. a phase, which then does not matter."""
    low: float
    """Lower end of what is plausible on an industrial robot."""
    high: float
    """Upper end."""
    source: str
    """Where the range comes from."""
    per: Per
    minimum: float
    """Smallest value that makes sense."""
    maximum: float
    """Largest value that makes sense."""
    role: Role
    """What it is to a search among effects."""
    tries: tuple[float, ...]
    """Values of a shape at which a search begins; empty is the default value alone. Of cycles, where joints move too
    little to show a period; empty are those that what is to be explained has per motor turn."""
    default: float | None
    """Value if none is given; None if one must be."""
    scale: Scale = ""
    """What of a robot it is where nobody gives it: it only says in what a size counts, and is not fitted."""
    of: tuple[str, str] | None = None
    """Part and number of the description that it is a share of, more or less of it; None is nothing."""

    @property
    def is_looked_for(self) -> bool:
        """Whether it is a frequency that what is to be explained must show."""
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

    def checked(self, owner: str, value: Any, n_joints: int) -> Array:
        """Return `value` as an array of the right shape; one number stands for all joints.

        Raises:
            FFGymError: if it has another shape, is not finite, or is below or above what makes sense.
        """
        shape, name = self.shape(n_joints), f"{owner}.{self.name}"
        array = self.numbers(owner, value)
        array = check_shape(name, array if array.ndim else np.full(shape, array), shape)
        if np.any(array < self.minimum):
            raise FFGymError(f"{name} = {array.tolist()} {self.unit} must be at least {self.minimum:g} {self.unit}.")
        if np.any(array > self.maximum):
            raise FFGymError(f"{name} = {array.tolist()} {self.unit} must be at most {self.maximum:g} {self.unit}.")
        return array


def parameter(
    meaning: str,
    *,
    unit: str,
    low: float,
    high: float,
    source: str,
    null: float | None = 0.0,
    per: Per = "joint",
    minimum: float = -np.inf,
    maximum: float = np.inf,
    default: float | None = None,
    role: Role | None = None,
    tries: tuple[float, ...] = (),
    scale: Scale = "",
    of: tuple[str, str] | None = None,
) -> Any:
    """Field of an effect's dataclass that is a parameter.

    Args:
        meaning: one phrase, with the side where there are two.
        unit: SI; '1' for a pure number.
        low: lower end of what is plausible.
        high: upper end.
        source: where the range comes from.
        null: value at which the effect vanishes; None for a parameter of shape.
        per: what there is one number for.
        minimum: smallest value that makes sense.
        maximum: largest value that makes sense.
        default: value if none is given; None requires one.
        role: None is a size where there is a null value, else a shape.
        tries: values of a shape at which a search begins; none is the default value alone.
        scale: what of a robot a search takes it to be; it is not fitted.
        of: part and number of the description that it is a share of, e.g. ("friction", "coulomb").
    """
    known = Parameter(
        name="",
        meaning=meaning,
        unit=unit,
        null=null,
        low=low,
        high=high,
        source=source,
        per=per,
        minimum=minimum,
        maximum=maximum,
        role=role or ("shape" if null is None else "size"),
        tries=tries,
        default=default,
        scale=scale,
        of=of,
    )
    if default is None:
        return field(metadata={_KEY: known})
    return field(default=np.float64(default), metadata={_KEY: known})  # spread over the joints by Parameter.checked


def declared(metadata: Any) -> Parameter | None:
    """The parameter that a dataclass field declares, if any; its name is still empty."""
    found = metadata.get(_KEY)
    return found if isinstance(found, Parameter) else None

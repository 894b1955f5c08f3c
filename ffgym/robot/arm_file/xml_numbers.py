"""Numbers in attributes of XML."""

from xml.etree import ElementTree as ET

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array


def numbers(element: ET.Element, attribute: str, what: str, default: tuple[float, ...]) -> Array:
    """As many numbers as `default` has from an attribute; `default` if it is not there.

    Raises:
        FFGymError: if they are not; `what` names the element.
    """
    text = element.get(attribute)
    if text is None:
        return np.array(default)
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.empty(0)
    if len(values) != len(default) or not np.all(np.isfinite(values)):
        count = "a number" if len(default) == 1 else f"{len(default)} numbers"
        raise FFGymError(f"{what}: {attribute} = {text!r} must be {count}.")
    return values


def number(element: ET.Element, attribute: str, what: str, default: float) -> float:
    """One number from an attribute; `default` if it is not there.

    Raises:
        FFGymError: if it is none; `what` names the element.
    """
    return float(numbers(element, attribute, what, (default,))[0])

"""Refusals of motions that an arm cannot make."""

import pytest

from ffgym.core.errors import FFGymError


def refused(message, make):
    """Check that `make` ends with an error of one line that has the message."""
    with pytest.raises(FFGymError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)

"""Published recordings of real machines: found where FFGYM_DATA says."""

import pytest

from ffgym.core.errors import FFGymError
from ffgym.studies.measured import measured_folder


@pytest.mark.parametrize("value", [None, "", "/no/such/folder"])
def test_a_missing_folder_is_one_error_that_names_the_variable(value, monkeypatch):
    monkeypatch.delenv("FFGYM_DATA", raising=False)
    if value is not None:
        monkeypatch.setenv("FFGYM_DATA", value)
    with pytest.raises(FFGymError, match="FFGYM_DATA"):
        measured_folder()

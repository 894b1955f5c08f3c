"""Tables of an identified rigid body: numbers that logs do not determine are left out, not written as if they were."""

import numpy as np
import pytest

from ffgym.report.identification.rigid_body import ParameterRow, _interval, _known

ROW = {"name": "coulomb.j1", "unit": "N m", "before": 0.5, "now": 0.5, "low": 0.5, "high": 0.5, "share": 0.0}


@pytest.mark.parametrize(("verdict", "interval"), [("not excited", None), ("data", "0.5 to 0.5")])
def test_a_parameter_that_keeps_its_value_has_no_interval(verdict, interval):
    assert _interval(ParameterRow(**ROW, verdict=verdict)) == interval


def test_a_joint_that_does_not_move_has_no_error():
    assert _known(np.nan) is None
    assert _known(np.float64(0.25)) == 0.25

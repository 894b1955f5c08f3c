"""The claims about re-identified friction are decided by path and motor errors, circle by circle and joint by joint."""

from types import SimpleNamespace

import pytest

from ffgym.diagnosis.identification.estimate import Estimate
from scripts.thesis import ITEMS
from scripts.thesis.claims import judge

CLAIMS = {claim.name: claim for item in ITEMS for claim in item.claims}
[REIDENTIFIED] = [item for item in ITEMS if item.name == "reidentified"]
LAWS = ("none", "lugre_dynamic", "lugre_identified")


@pytest.fixture
def with_errors(studies, made_up_circles):
    """Function that puts circles into the studies: what the identified parameters leave of old errors, by speed."""

    def put(slow, fast):
        left = {0.010: slow, 0.040: fast, 0.100: 1.0}

        def path(law, speed, radius, position):
            return {"lugre_identified": left[speed], "lugre_dynamic": 1.0, "none": 9.0}[law]

        def motor(law, speed, position, joint):
            return 1e-3 * path(law, speed, None, position)

        studies.reidentified_circles = made_up_circles(LAWS, path, motor).only(speeds=[0.010, 0.040])
        return studies

    return put


@pytest.mark.parametrize("name", ["reidentified-mean", "reidentified-circles", "reidentified-motors"])
def test_the_claims_hold_where_identified_parameters_leave_less(name, with_errors):
    assert judge(CLAIMS[name], with_errors(0.8, 0.9)).verdict == "holds"
    assert judge(CLAIMS[name], with_errors(0.8, 1.1)).verdict == "partly"
    assert judge(CLAIMS[name], with_errors(1.0, 1.0)).verdict == "does not hold"


def test_the_tables_say_how_much_less_and_which_parameters_are_not_identified(with_errors):
    studies = with_errors(0.8, 1.1)
    known = {"name": "friction.coulomb", "joint": "j1", "unit": "N m", "side": "motor", "value": 0.5, "prior": 0.6}
    sure = Estimate(**known, low=0.4, high=0.6, status="identified")
    unsure = Estimate(**known, low=0.0, high=9.0, status="wide")
    joint = SimpleNamespace(joint="j1", estimates=(sure, unsure))
    studies.all_joints = SimpleNamespace(found=SimpleNamespace(joints=(joint,)))
    errors, parameters = REIDENTIFIED.numbers(studies)
    assert errors.rows[0] == ("10 mm/s", "9.0000", "1.0000", "0.8000", "20% less", "12 of 12")
    assert errors.rows[1][-2:] == ("10% more", "0 of 12")
    assert parameters.rows == (("j1", "0.6 → 0.5", "0.6 → 0.5 *"),)


def test_the_figure_has_bars_of_both_sets_of_parameters(with_errors):
    [figure] = REIDENTIFIED.figures(with_errors(0.8, 0.9))
    assert "dynamic LuGre, identified" in figure.caption

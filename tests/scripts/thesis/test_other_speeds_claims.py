"""Figure 3.3, and claims of thesis 5.5 on networks at other speeds, for results as described and for others."""

import numpy as np
import pytest

from ffgym.report.circles.comparison import percent
from scripts.thesis.measures import KNOTS, PLACES, printed_splines, splines_of
from scripts.thesis.pictures import orders
from scripts.thesis.tables import other_speeds

LAWS = ("none", "bsn_static", "bsn_extended")
TRAINED = {"bsn_circles": 0.010, "networks_of_40": 0.040, "networks_of_100": 0.100}


@pytest.fixture
def made_up(made_up_circles):
    """Function that makes results of every training; `left(trained, used)` is the share of errors that stays."""

    def make(left):
        return {
            of: made_up_circles(
                LAWS,
                path=lambda law, speed, *_, at=at: 1.0 if law == "none" else left(at, speed),
                motor=lambda law, speed, *_, at=at: 1e-3 if law == "none" else 1e-3 * left(at, speed),
            )
            for of, at in TRAINED.items()
        }

    return make


@pytest.mark.parametrize("name", ["other-speeds-faster", "other-speeds-slower"])
def test_claims_hold_where_networks_gain_at_their_own_speed_only(name, made_up, verdict):
    assert verdict(name, **made_up(lambda at, used: 0.4 if at == used else 0.9)) == "holds"


@pytest.mark.parametrize("name", ["other-speeds-faster", "other-speeds-slower"])
def test_claims_do_not_hold_where_the_training_does_not_matter(name, made_up, verdict):
    assert verdict(name, **made_up(lambda at, used: 0.5)) == "does not hold"


def test_the_table_has_every_training_at_every_speed(made_up, studies):
    for of, value in made_up(lambda at, used: at + used).items():
        setattr(studies, of, value)
    columns = other_speeds(studies).columns
    assert columns[0].values[0] == "no compensation"
    rows = [f"{at + 0.010:.4f} ({percent(1 - at - 0.010)})" for at in TRAINED.values()]
    assert columns[1].values == ["1.0000", *rows, *rows]


def test_the_splines_of_figure_3_3_are_pieces_hats_and_parabolas(verdict):
    for order, peak in ((1, 1.0), (2, 1.0), (3, 0.75)):
        _, values = splines_of(order)
        assert values.shape[1] == len(KNOTS) - order
        assert values.max() == pytest.approx(peak, abs=1e-6)
        pieces = (values[:, 0] > 0) & (KNOTS[1] > PLACES)
        assert np.abs(np.diff(values[pieces, 0], order)).max() < 1e-9  # a polynomial of degree order - 1
    assert verdict("3.3-range") == "holds"


def test_the_recursion_as_printed_makes_a_hat_with_a_step(verdict):
    steps = np.abs(np.diff(printed_splines(2)[:, 0])).max()
    assert steps > 0.4
    assert np.abs(np.diff(splines_of(2)[1][:, 0])).max() < 0.01
    assert verdict("3.3-recursion") == "does not hold"


def test_figure_3_3_has_a_column_for_each_order(studies):
    (figure,) = orders(studies, "figure-3.3")
    assert [len(axes.lines) for axes in figure.figure.axes] == [4, 4, 3, 4, 5, 6]

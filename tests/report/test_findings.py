import pytest

from ffgym.report import findings, headline
from ffgym.report.circles.comparison import percent


def test_a_simulation_that_equals_the_real_robot_reproduces_everything(made_up):
    verdicts = {finding.verdict for finding in findings(made_up())}
    assert verdicts == {"reproduced"}


def test_a_law_of_the_wrong_size_is_not_reproduced_and_only_that(made_up):
    study = made_up(lambda law, *where: 0.1 if law == "lugre_dynamic" else 1.0)
    missed = [finding.question for finding in findings(study) if finding.verdict == "not reproduced"]
    assert missed == [f"{speed} mm/s: size of the path error with dynamic LuGre" for speed in (10, 40)]


def test_circles_on_which_simulation_and_robot_differ_are_named(made_up):
    study = made_up(lambda law, speed, radius, position: 9 if (law, position) == ("lugre_static", "p2") else 1)
    [finding] = [f for f in findings(study) if f.question == "40 mm/s: is static LuGre better than no compensation?"]
    assert finding.verdict == "reproduced"
    assert "smaller error on 9 simulated and 12 published" in finding.text
    assert "They differ on 1 mm at p2, 3 mm at p2, 5 mm at p2." in finding.text


def test_half_of_the_circles_is_partly_and_less_is_not(made_up):
    def verdict(good: tuple[str, ...]) -> str:
        return findings(made_up(lambda law, speed, radius, position: 1 if position in good else 3))[0].verdict

    assert verdict(("p1", "p2", "p3")) == "reproduced"
    assert verdict(("p1", "p2")) == "partly reproduced"
    assert verdict(("p1",)) == "not reproduced"


def test_a_speed_without_published_numbers_is_not_comparable(circle):
    assert [f.verdict for f in findings(circle) if f.question.startswith("100 mm/s")] == ["not comparable"]


def test_the_headline_says_more_when_compensation_makes_it_worse(made_up, sine):
    better, worse = headline(made_up(lambda law, speed, *_: 5 if law != "none" and speed == 0.04 else 1), sine)[:2]
    assert "At 10 mm/s" in better
    assert "54% less than the 0.105 mm with no compensation (real robot: 54% less)" in better
    assert "more than the 0.231 mm with no compensation (real robot: 27% less)" in worse


def test_the_headline_takes_the_best_law_of_the_slowest_speed(made_up, sine):
    [sentence, *_] = headline(made_up(lambda law, *_: 0.1 if law == "lugre_static" else 1), sine)
    assert "with static LuGre is" in sentence


def test_the_headline_never_takes_the_oracle_as_the_best_law(made_up, sine):
    best = made_up(
        lambda law, *_: 0.1 if law == "lugre_static" else 1,
        rename=lambda law: "oracle" if law == "lugre_static" else law,
    )
    [sentence, *_] = headline(best, sine)
    assert "with dynamic LuGre is" in sentence


def test_the_headline_counts_circles_near_the_real_robot(made_up, sine):
    sentences = headline(made_up(lambda law, speed, radius, position: 1.2 if position == "p1" else 2), sine)
    assert any("on 6 of 24 circles (median ratio 2.00)" in sentence for sentence in sentences)


@pytest.mark.parametrize(
    ("share", "words"),
    [(0.53, "53% less"), (-0.2, "20% more"), (0.997, "99.7% less"), (0.99985, "99.98% less"), (0, "0% less")],
)
def test_reductions_are_put_in_words(share, words):
    assert percent(share) == words

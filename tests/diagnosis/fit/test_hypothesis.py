"""What a linear fit says becomes an effect with values, and stays within what is possible."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.hypothesis import Hypothesis, move_hypotheses
from ffgym.diagnosis.search.ranking import build_hypothesis
from ffgym.diagnosis.sensitivity import Sensitivity
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.variant import list_variants
from ffgym.effects import EFFECTS
from ffgym.robot import load_robot


@pytest.fixture(scope="module")
def robot():
    return load_robot("two_link")


def columns_for(kind, robot, joint):
    """The columns that the search would make of an effect on one joint, without what they show."""
    cycles = {name: [2.0] for name in robot.joints}
    return [
        Sensitivity(
            effect=kind,
            joint=joint,
            parameter=v.parameter,
            part=v.part,
            choice=v.choice,
            span=v.span,
            shape={name: np.asarray(value).ravel()[0] for name, value in v.shape.items()},
            parts={},
        )
        for v in list_variants(kind, robot, cycles)
        if v.choice == 0
    ]


def test_a_sine_and_a_cosine_become_amplitude_and_phase(robot):
    kind, amplitude, phase = EFFECTS["cogging"], 0.03, 1.1
    columns = columns_for(kind, robot, "elbow" if "elbow" in robot.joints else robot.joints[1])
    assert len(columns) == 2
    found = build_hypothesis(columns, amplitude * np.array([np.cos(phase), np.sin(phase)]), robot)
    assert float(found.values["amplitude"]) == pytest.approx(amplitude)
    assert float(found.values["phase"]) == pytest.approx(phase)
    effect = found.effect(robot)
    np.testing.assert_allclose(effect.amplitude, [0.0, amplitude])


def test_sizes_become_the_effect_on_its_joint_alone(robot):
    columns = columns_for(EFFECTS["coulomb_level"], robot, robot.joints[0])
    effect = build_hypothesis(columns, np.array([0.2]), robot).effect(robot)
    np.testing.assert_allclose(effect.change, [0.2, 0.0])


@pytest.mark.parametrize(
    "name", ["load_friction", "coulomb_level", "joint_stiffness", "backlash", "payload", "cogging"]
)
@pytest.mark.parametrize("change", [-1e6, -0.1, 0.0, 0.1, 1e6])
def test_a_moved_hypothesis_stays_within_its_bounds_and_can_be_built(name, change, robot):
    kind = EFFECTS[name]
    values = {n: np.array(_usual(p)) for n, p in kind.parameters().items()}
    joint = robot.joints[0] if any(p.per == "joint" for p in kind.parameters().values()) else ""
    begun = Hypothesis(kind=kind, joint=joint, source=None, values=values)
    moved = begun.move([change] * len(begun.list_free()))
    for before, after in zip(begun.list_free(), moved.list_free(), strict=True):
        assert before.low <= after.value <= before.high
        assert after.value == pytest.approx(np.clip(before.value + change, before.low, before.high))
    moved.effect(robot)


def test_a_shape_is_fitted_within_its_plausible_range_as_a_drift_of_a_second_is_a_level(robot):
    kind = EFFECTS["coulomb_drift"]
    known = kind.parameters()["duration"]
    begun = Hypothesis(
        kind=kind,
        joint=robot.joints[0],
        source=None,
        values={"share": np.array(0.1), "duration": np.array(known.default)},
    )
    for change in (-1e6, 1e6):
        assert known.low <= float(begun.move([0.0, change]).values["duration"]) <= known.high


def test_friction_that_repeats_after_many_turns_is_a_level_so_that_it_is_not_fitted_that_far(robot):
    kind = EFFECTS["position_friction"]
    known = kind.parameters()["cycles"]
    values = {"share": np.array(0.1), "cycles": np.array(known.tries[0]), "phase": np.array(0.0)}
    begun = Hypothesis(kind=kind, joint=robot.joints[0], source=None, values=values)
    for change in (-1e6, 1e6):
        moved = begun
        for _ in range(20):  # each step is bounded by the one before
            moved = moved.move([0.0, change, 0.0])
        assert known.low <= float(moved.values["cycles"]) <= known.high


def _usual(p):
    value = p.neutral + 0.1 * (p.high - p.neutral) if p.role == "size" else p.default
    value = p.low if value is None else value
    return np.full(3, value) if p.per == "vector" else value


def test_how_long_a_session_takes_to_change_something_is_not_fitted_anew_where_rows_are_left_out():
    """Sizes and exponents are, and calibration; without the first recording of a session a duration is a guess."""
    drift = Hypothesis(
        kind=EFFECTS["viscous_drift"],
        joint="j1",
        source=None,
        values={"share": np.array(0.2), "duration": np.array(1800.0), "exponent": np.array(1.0)},
    )
    backlash = EFFECTS["backlash"].parameters()
    gap = Hypothesis(
        kind=EFFECTS["backlash"],
        joint="j2",
        source=None,
        values={name: np.array(p.high) for name, p in backlash.items()},
    )
    n_free = len(drift.list_free()) + len(gap.list_free())
    found = SimpleNamespace(
        hypotheses=(drift, gap), n_nuisances=2, calibration_only=np.arange(2), columns=((),) * n_free
    )
    held = [number.name for h in (drift, gap) for number in h.list_free() if number.of_session]
    assert held == ["duration"]
    names = ["c", "c"] + [number.name for h in (drift, gap) for number in h.list_free()]
    assert [names[i] for i in Fit.fold_columns.fget(found)] == [name for name in names if name != "duration"]


@pytest.mark.parametrize(
    ("name", "sizes", "is_unphysical"),
    [
        ("joint_stiffness", {"change": 14.3}, True),
        ("joint_stiffness", {"change": -0.5}, False),
        ("nonlinear_viscous", {"share": -1.4, "speed": 470.0}, False),  # of a recorded robot
        ("torque_offset", {"offset": 300.0}, False),  # a large robot may
    ],
)
def test_no_machine_has_a_spring_fifteen_times_as_stiff_as_described(name, sizes, is_unphysical):
    values = {key: np.array(value) for key, value in sizes.items()}
    assert Hypothesis(kind=EFFECTS[name], joint="j1", source=None, values=values).is_unphysical == is_unphysical


def hypothesis_of(name, joint="j1", null=(), **values):
    kind = EFFECTS[name]
    return Hypothesis(
        kind=kind, joint=joint, source=None, values={k: np.array(v) for k, v in values.items()}, null=frozenset(null)
    )


def test_a_size_is_scaled_about_its_null_value_and_a_shape_is_not():
    begun = hypothesis_of("cogging", amplitude=0.02, cycles=6.0, phase=0.5)
    scaled = begun.scale(3.0)
    assert float(scaled.values["amplitude"]) == pytest.approx(0.06)
    assert (float(scaled.values["cycles"]), float(scaled.values["phase"])) == (6.0, 0.5)
    assert float(begun.values["amplitude"]) == 0.02
    low = EFFECTS["joint_stiffness"].parameters()["change"].minimum
    assert float(hypothesis_of("joint_stiffness", change=-0.5).scale(1e3).values["change"]) == low


def test_a_size_that_is_held_at_its_null_value_is_not_fitted():
    begun = hypothesis_of("cogging", amplitude=0.02, cycles=6.0, phase=0.5)
    assert not begun.is_null
    held = begun.fix_at_null("amplitude")
    assert held.is_null
    assert [free.name for free in begun.list_free()] == ["amplitude", "cycles", "phase"]
    assert [free.name for free in held.list_free()] == ["cycles", "phase"]


def test_numbers_of_a_vector_are_moved_one_by_one():
    known = EFFECTS["payload"].parameters()
    (vector,) = (name for name, p in known.items() if p.per == "vector")
    values = {name: _usual(p) for name, p in known.items()}
    begun = hypothesis_of("payload", joint="", **values)
    free = begun.list_free()
    assert [one.part for one in free if one.name == vector] == [0, 1, 2]
    changes = [0.01 * k for k, _ in enumerate(free, start=1)]
    moved = begun.move(changes)
    for one, change in zip(free, changes, strict=True):
        now = moved.values[one.name] if one.part is None else moved.values[one.name][one.part]
        assert float(now) == pytest.approx(one.value + change)
    with pytest.raises(ValueError, match="shorter"):
        begun.move(changes[:-1])


def test_a_wave_of_another_frequency_is_another_cause_and_one_nearby_is_not():
    begun = hypothesis_of("cogging", amplitude=0.02, cycles=6.0, phase=0.5)
    other = settings().search.other_wave
    near, far = (
        hypothesis_of("cogging", amplitude=0.5, cycles=6.0 / (1 + share * other), phase=0.0) for share in (0.9, 1.1)
    )
    elsewhere = hypothesis_of("cogging", joint="j2", amplitude=0.02, cycles=6.0, phase=0.5)
    assert [begun.repeats(other) for other in (near, far, elsewhere)] == [True, False, False]
    assert begun.is_among([far, near])
    assert not begun.is_among([far, elsewhere])


def test_a_size_far_beyond_what_is_plausible_is_told_with_its_unit():
    p = EFFECTS["cogging"].parameters()["amplitude"]
    widths = settings().search.implausible

    def at(beyond):
        value = p.high + beyond * widths * (p.high - p.low)
        return hypothesis_of("cogging", amplitude=value, cycles=6.0, phase=0.0).implausible

    assert at(0.99) is None
    assert at(1.0) is None
    assert f"N m, where {p.low:g} to {p.high:g} is plausible" in at(1.01)
    assert hypothesis_of("cogging", amplitude=0.02, cycles=1e9, phase=0.0).implausible is None  # no size
    share = EFFECTS["load_friction"].parameters()["share"]
    told = hypothesis_of("load_friction", share=share.high + 1.01 * widths * (share.high - share.low)).implausible
    assert told.partition(",")[0].split(" of ")[1].replace(".", "").isdigit()  # a share has no unit


def test_practical_steps_move_all_hypotheses_in_their_order():
    both = [hypothesis_of("cogging", amplitude=0.02, cycles=6.0, phase=0.5), hypothesis_of("load_friction", share=0.1)]
    free = [number for one in both for number in one.list_free()]
    moved = move_hypotheses(both, np.array([0.1, 0.0, -0.2, 0.3]))
    then = [number.value for one in moved for number in one.list_free()]
    wanted = [one.value + x * one.step for one, x in zip(free, (0.1, 0.0, -0.2, 0.3), strict=True)]
    np.testing.assert_allclose(then, wanted)


def test_a_size_whose_null_value_is_not_zero_is_scaled_about_it():
    sizes = [
        (kind.name, name, p)
        for kind in EFFECTS.values()
        for name, p in kind.parameters().items()
        if p.role == "size" and p.neutral != 0
    ]
    assert sizes
    for effect, name, p in sizes:
        value = p.neutral + 0.1 * (p.high - p.neutral)
        scaled = hypothesis_of(effect, **{name: value}).scale(2.0)
        assert float(scaled.values[name]) == pytest.approx(p.neutral + 0.2 * (p.high - p.neutral))
        assert hypothesis_of(effect, **{name: value}).scale(0.0).is_null


def find_free(one, name):
    """The free number of a hypothesis by its name."""
    (found,) = (free for free in one.list_free() if free.name == name)
    return found


def test_a_practical_step_is_a_tenth_of_the_plausible_range_of_a_shape():
    known = EFFECTS["viscous_drift"].parameters()["exponent"]
    drift = hypothesis_of("viscous_drift", share=0.2, duration=600.0, exponent=known.low)
    free = find_free(drift, "exponent")
    assert free.step == pytest.approx(0.1 * (known.high - known.low))
    assert (free.low, free.high) == (known.low, known.high)
    assert not free.of_session
    assert find_free(drift, "duration").of_session


def test_a_shape_beyond_its_plausible_range_may_stay_there():
    known = EFFECTS["viscous_drift"].parameters()["exponent"]
    for value in (known.low - 0.1, known.high + 0.1):
        free = find_free(hypothesis_of("viscous_drift", share=0.2, duration=600.0, exponent=value), "exponent")
        assert (free.low, free.high) == (min(value, known.low), max(value, known.high))


def test_a_frequency_that_residuals_show_is_sought_near_it():
    """By a share of itself, or of one period per turn if it is less; and above 0."""
    share = settings().search.frequency_step
    for value, step in ((6.0, 6.0 * share), (1.5, 1.5 * share), (0.5, share), (0.5 * share, share)):
        free = find_free(hypothesis_of("cogging", amplitude=0.02, cycles=value, phase=0.5), "cycles")
        assert free.step == pytest.approx(step)
        assert free.low == pytest.approx(max(0.0, value - step))
        assert free.high == pytest.approx(value + step)


def test_a_frequency_between_those_that_were_tried_is_sought_half_the_way_to_the_next():
    known = EFFECTS["position_friction"].parameters()["cycles"]
    assert known.tries[:3] == (1.0, 5.0, 10.0)
    for value, low, high in ((20.0, 18.0, 22.0), (2.0, known.low, 4.0), (39.5, 37.5, known.high)):
        free = find_free(hypothesis_of("position_friction", share=0.1, cycles=value, phase=0.5), "cycles")
        assert (free.step, free.low, free.high) == (2.0, low, high)


def test_a_phase_is_free_and_its_practical_step_is_less_than_a_radian():
    free = find_free(hypothesis_of("cogging", amplitude=0.02, cycles=6.0, phase=0.5), "phase")
    assert 0.0 < free.step < 1.0
    assert (free.low, free.high) == (-np.inf, np.inf)


def test_slopes_are_found_by_changes_that_are_small_and_not_lost_in_rounding():
    for one in (
        hypothesis_of("cogging", amplitude=0.02, cycles=60.0, phase=0.5),
        hypothesis_of("cogging", amplitude=0.02, cycles=0.2, phase=0.5),
        hypothesis_of("viscous_drift", share=0.2, duration=600.0, exponent=1.0),
    ):
        for free in one.list_free():
            assert 1e-7 * max(abs(free.value), 1.0) < free.nudge < 0.2 * free.step
            assert free.name == "cycles" or free.nudge > 1e-3 * free.step


def test_slopes_of_a_frequency_are_found_by_a_share_of_it_or_of_one_if_it_is_less():
    one, many, few = (
        find_free(hypothesis_of("cogging", amplitude=0.02, cycles=cycles, phase=0.5), "cycles").nudge
        for cycles in (1.0, 60.0, 0.2)
    )
    assert many == pytest.approx(60 * one)
    assert few == one


def test_a_share_just_as_far_off_as_a_machine_may_be_is_physical():
    share = EFFECTS["load_friction"].parameters()["share"]
    assert share.low == 0.0
    ten = share.high * settings().search.unphysical
    assert not hypothesis_of("load_friction", share=share.high + ten).is_unphysical
    assert hypothesis_of("load_friction", share=1.01 * (share.high + ten)).is_unphysical
    assert hypothesis_of("load_friction", share=-1.01 * ten).is_unphysical


def test_an_effect_of_one_joint_on_another_is_at_their_place(robot):
    pairs = [kind for kind in EFFECTS.values() if any(p.per == "pair" for p in kind.parameters().values())]
    assert pairs
    for kind in pairs:
        values = {name: np.array(_usual(p)) for name, p in kind.parameters().items()}
        size = next(name for name, p in kind.parameters().items() if p.per == "pair")
        one = Hypothesis(kind=kind, joint=robot.joints[1], source=0, values=values)
        found = getattr(one.effect(robot), size)
        assert found[1, 0] == values[size]
        np.testing.assert_array_equal(found[[0, 0, 1], [0, 1, 1]], kind.parameters()[size].neutral)
        assert one.key == (kind.name, robot.joints[1], 0)

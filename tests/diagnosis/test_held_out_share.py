"""Share of the misfit that causes explain on motions that were left out."""

from dataclasses import replace

import pytest

from ffgym.diagnosis.held_out_share import compute_held_out_share, find_loudest, name_place
from ffgym.diagnosis.result import Level
from tests.diagnosis.result_samples import full_diagnosis, left


def excess(value, floor):
    return (value / floor) ** 2 - 1


def test_the_share_is_that_of_the_joint_in_the_channel_that_is_explained_and_at_most_all_of_it():
    levels = full_diagnosis().levels
    found = compute_held_out_share(levels, ["j2"])
    assert (found.share, found.channel) == (pytest.approx(1 - excess(0.013, 0.012) / excess(0.09, 0.012)), "torque")
    quieter = [replace(level, after=0.5 * level.noise_floor) for level in levels]
    assert compute_held_out_share(quieter, ["j2"]).share == 1.0
    worse = [replace(level, after=2 * level.before) for level in levels]
    assert compute_held_out_share(worse, ["j2"]).share == 0.0


def test_several_joints_share_the_energy_of_all_and_each_component_counts_once():
    levels = full_diagnosis().levels
    before = excess(0.09, 0.012) + excess(0.011, 0.01)
    after = excess(0.013, 0.012) + excess(0.0105, 0.01)
    levels = levels[:2]
    assert compute_held_out_share(levels, ["j2", "j1", "j2"]).share == pytest.approx(1 - after / before)


def test_a_machine_as_a_whole_has_the_channel_in_which_it_stands_out_most():
    levels = full_diagnosis().levels
    assert compute_held_out_share(levels, [""]).channel == "torque"
    louder = (*levels, Level(channel="link", component="j1", unit="rad", **left(1.0, 0.01, 0.9, 0.01)))
    found = compute_held_out_share(louder, [""])
    assert (found.share, found.channel) == (1.0, "link")


def test_a_joint_that_is_called_like_an_axis_of_the_tool_has_no_other_axes():
    tool = [
        Level(channel="tool", component=axis, unit="m", **left(1.0, 1.0, 9.0, after))
        for axis, after in (("x", 1.0), ("y", 9.0))
    ]
    assert compute_held_out_share(tool, ["x"]).share == 1.0
    assert compute_held_out_share(tool, ["j1"]).share == pytest.approx(0.5)


def test_a_misfit_of_the_tool_that_another_joint_makes_is_not_held_against_a_cause():
    """As a ripple of j5 beside a gap of j1, which no cause stands for."""
    tool = Level(channel="tool", component="y", unit="m", **left(0.2, 1e-5, 3e-4, 3e-4))
    torque = Level(channel="torque", component="j5", unit="N m", **left(0.5, 1e-3, 1e-2, 3e-3))
    found = compute_held_out_share((tool, torque), ["j5"])
    assert (found.share, found.channel) == (pytest.approx(1 - excess(3e-3, 1e-3) / excess(1e-2, 1e-3)), "torque")


def test_there_is_no_share_where_nothing_was_left_out_or_wrong():
    levels = full_diagnosis().levels
    assert compute_held_out_share([replace(level, after=level.before) for level in levels], ["j2"]) is None
    assert compute_held_out_share(levels, ["j7"]) is not None  # by the tool
    assert compute_held_out_share(levels[:2], ["j7"]) is None
    assert compute_held_out_share((), ["j2"]) is None


def test_the_place_of_a_share_names_some_joints_one_by_one_and_the_tool_as_a_whole():
    tool = Level(channel="tool", component="x", unit="m", **left(1.0, 0.1, 0.5, 0.1))
    torques = [
        Level(channel="torque", component=f"j{j}", unit="N m", **left(1.0, 0.1, 0.5, 0.1 * j)) for j in (1, 2, 3, 4)
    ]
    assert name_place([torques[1], torques[3], tool]) == "the torque of j2 and j4, and the tool position"
    assert name_place(torques) == "the torque"
    assert find_loudest([tool, *torques]) is torques[3]
    assert find_loudest([tool]) is None

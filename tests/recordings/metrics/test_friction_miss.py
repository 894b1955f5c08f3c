"""How far added torque is from friction, as a share of the friction."""

import numpy as np
import pytest

from ffgym.recordings.metrics import friction_miss, relative_rms
from ffgym.simulation import Run, simulate
from ffgym.studies import sine_references


@pytest.fixture(scope="module")
def recording(one_axis):
    return simulate([Run(reference=sine_references(one_axis, [1.0])[1.0])])[0]


def with_added(recording, torque):
    return recording.with_columns({f"compensation.effort.{recording.header.joints[0]}": torque})


def test_nothing_added_misses_all_friction_and_friction_itself_misses_none(recording):
    friction = recording.joint_array("friction.effort")[:, 0]
    assert friction_miss(recording) == pytest.approx([1.0])
    assert friction_miss(with_added(recording, friction)) == pytest.approx([0.0])


def test_the_miss_is_a_share_of_the_friction(recording):
    friction = recording.joint_array("friction.effort")[:, 0]
    assert friction_miss(with_added(recording, 0.8 * friction)) == pytest.approx([0.2])


def test_only_the_chosen_rows_count(recording):
    friction = recording.joint_array("friction.effort")[:, 0]
    late = recording.t > 5.0
    assert friction_miss(with_added(recording, np.where(late, friction, 0.0)), late) == pytest.approx([0.0])


def test_where_there_is_no_friction_nothing_is_missed():
    assert relative_rms(np.ones((4, 2)), np.array([[2.0, 0.0]] * 4)).tolist() == [0.5, 0.0]

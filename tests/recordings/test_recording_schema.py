import numpy as np
import pytest
from recording_samples import JOINTS, columns, header, refused

from ffgym.core.errors import FFGymError
from ffgym.recordings import FAMILIES, Recording
from ffgym.recordings.schema import check_columns, family_named


def test_every_family_is_accepted_with_all_its_columns() -> None:
    names = [column for family in FAMILIES.values() for column in family.columns(JOINTS)]
    check_columns(names, JOINTS, {})
    assert len(set(names)) == len(names)


def test_every_family_states_unit_and_meaning() -> None:
    for name, family in FAMILIES.items():
        assert family.name == name
        assert family.unit
        assert family.meaning


def test_only_header_fields_decide_the_side_of_a_family() -> None:
    for family in FAMILIES.values():
        assert not family.decided_by or hasattr(header(), family.decided_by)


def test_only_tool_measurements_and_temperatures_may_miss_samples() -> None:
    assert {name for name, family in FAMILIES.items() if family.may_miss} == {
        "tcp.position",
        "tcp.orientation",
        "tcp.timestamp",
        "temperature",
    }


@pytest.mark.parametrize("name", ["motor.postion.j1", "motor_position.j1", "Motor.Position.j1"])
def test_misspelt_column_is_refused_with_the_closest_names(name: str) -> None:
    with refused("Closest: motor.position.j1"):
        check_columns([name], JOINTS, {})


def test_family_without_joint_or_axis_is_refused_with_the_columns_it_stands_for() -> None:
    with refused("Column 'motor.position' lacks its last part, must be motor.position.j1, motor.position.j2"):
        check_columns(["motor.position"], JOINTS, {})


def test_column_unlike_any_other_is_refused_with_all_names() -> None:
    with refused("Available: timestamp, motor.position.j1"):
        check_columns(["0123456789"], JOINTS, {})


def test_unknown_joint_is_refused_with_the_joints_of_the_header() -> None:
    with refused("Column 'motor.effort.j7' names joint 'j7', but header.joints is ('j1', 'j2')"):
        check_columns(["motor.effort.j7"], JOINTS, {})


def test_family_with_a_missing_joint_is_refused() -> None:
    with refused("motor.effort is incomplete: motor.effort.j2 missing"):
        check_columns(["motor.effort.j1"], JOINTS, {})


def test_vector_with_a_missing_axis_is_refused() -> None:
    with refused("tcp.position is incomplete: tcp.position.y missing"):
        check_columns(["tcp.position.x", "tcp.position.z"], JOINTS, {})


def test_user_column_needs_a_unit() -> None:
    check_columns(["user.pressure"], JOINTS, {"user.pressure": "Pa"})
    with refused("Column 'user.pressure' has no unit"):
        check_columns(["user.pressure"], JOINTS, {})


@pytest.mark.parametrize("name", ["user.", "user.a,b", "user.a\nb", "user.é", 'user."'])
def test_user_column_that_would_not_survive_a_file_is_refused(name: str) -> None:
    with refused("must be user. followed by letters"):
        check_columns([name], JOINTS, {name: "1"})


def test_column_name_must_be_text() -> None:
    with refused("Column names must be text, got 3"):
        Recording({**columns(), 3: [0.0] * 5}, header())  # type: ignore[dict-item]


def test_unknown_family_is_refused_with_the_closest() -> None:
    with refused("Unknown column family 'motor.efort'. Closest: motor.effort"):
        family_named("motor.efort")


def test_very_long_name_is_cut_in_the_message() -> None:
    with pytest.raises(FFGymError) as error:
        check_columns(["x" * 100_000], JOINTS, {})
    assert len(str(error.value)) < 1500


def test_an_orientation_is_read_as_scalar_first_quaternion() -> None:
    parts = ("qw", "qx", "qy", "qz")
    columns = {f"tcp.orientation.{part}": np.full(3, value) for part, value in zip(parts, (1.0, 0, 0, 0), strict=True)}
    recording = Recording({"timestamp": np.arange(3.0)} | columns, header())
    np.testing.assert_array_equal(recording.quaternion("tcp.orientation"), np.tile([1.0, 0, 0, 0], (3, 1)))
    with pytest.raises(FFGymError, match=r"recording\.quaternion"):
        recording.vector("tcp.orientation")


def test_encoders_behind_some_gearboxes_only_are_no_missing_columns() -> None:
    recording = Recording(columns(3) | {"link.position.j2": [0.1, 0.2, 0.3]}, header())
    assert recording.has("link.position")
    assert "link.position" in recording.families
    stacked = recording.joint_array("link.position")
    assert np.isnan(stacked[:, 0]).all()
    np.testing.assert_array_equal(stacked[:, 1], [0.1, 0.2, 0.3])

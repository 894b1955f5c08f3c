"""Corrections of columns do what they say, one after the other as in one, and come back from a column map."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.logs import parse_columns, read_log, write_corrected
from ffgym.recordings import Header, Recording, Rewire, Rewiring, write_recording


def recording() -> Recording:
    t = 0.01 * np.arange(50)
    columns = {"timestamp": t}
    for j, name in enumerate("ab"):
        columns[f"motor.position.{name}"] = np.sin((j + 2) * t)
        columns[f"motor.effort.{name}"] = np.cos((j + 3) * t)
    return Recording(columns, Header(robot="press", joints=("a", "b"), gear_ratio=(100.0, -80.0), segment="run"))


TURNED = Rewire.none(2).permute([1, 0]).scale_parts([0], [-2.0]).shift_parts([1], 0.5)
LATE = Rewire.none(2).delay_parts([0, 1], 0.03)


def test_columns_change_places_sign_and_zero():
    made, given = Rewiring(families={"motor.position": TURNED}).apply(recording()), recording()
    np.testing.assert_array_equal(made["motor.position.a"], -2.0 * given["motor.position.b"])
    np.testing.assert_array_equal(made["motor.position.b"], given["motor.position.a"] + 0.5)


def test_a_late_column_is_taken_from_later_rows_and_the_last_rows_go():
    made, given = Rewiring(families={"motor.effort": LATE}).apply(recording()), recording()
    assert len(made) == len(given) - 3
    np.testing.assert_array_equal(made["motor.effort.a"], given["motor.effort.a"][3:])
    np.testing.assert_array_equal(made["motor.position.a"], given["motor.position.a"][:-3])


def test_two_corrections_in_one_are_both_after_each_other():
    one = Rewiring(families={"motor.position": TURNED, "motor.effort": LATE}, clock=2.0)
    other = Rewiring(families={"motor.position": TURNED, "motor.effort": LATE})
    both, steps = one.then(other).apply(recording()), other.apply(one.apply(recording()))
    for name in ("timestamp", "motor.position.a", "motor.position.b"):
        np.testing.assert_allclose(both[name][: len(steps)], steps[name], rtol=1e-12)
    np.testing.assert_allclose(both["motor.effort.a"][:40], steps["motor.effort.a"][:40], atol=2e-3)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_a_map_of_corrections_mends_recordings(tmp_path, suffix):
    wiring = Rewiring(families={"motor.position": TURNED, "motor.effort": LATE}, clock=0.5)
    write_recording(recording(), tmp_path / f"run{suffix}")
    write_corrected(tmp_path / "columns.toml", wiring, None, ["signs"])
    made = read_log(tmp_path / f"run{suffix}", tmp_path / "columns.toml")
    assert dict(made.columns).keys() == recording().columns.keys()
    for name, values in wiring.apply(recording()).columns.items():
        np.testing.assert_array_equal(made[name], values)


def test_a_map_of_another_tool_keeps_what_it_says_and_gains_the_corrections(tmp_path):
    np.savez(tmp_path / "log.npz", t=0.01 * np.arange(50), q=np.random.default_rng(0).normal(size=(50, 2)))
    (tmp_path / "map.toml").write_text(
        '[log]\nrobot = "press"\njoints = ["a", "b"]\ngear_ratio = [2.0, 3.0]\n'
        '[columns.timestamp]\nsource = "t"\nunit = "s"\n[columns."motor.position"]\nsource = "q"\nunit = "deg"\n'
    )
    given = read_log(tmp_path / "log.npz", tmp_path / "map.toml")
    write_corrected(tmp_path / "new.toml", Rewiring(families={"motor.position": TURNED}), tmp_path / "map.toml")
    made = read_log(tmp_path / "log.npz", tmp_path / "new.toml")
    np.testing.assert_array_equal(made["motor.position.a"], -2.0 * given["motor.position.b"])
    write_corrected(tmp_path / "newer.toml", Rewiring(families={"motor.position": TURNED}), tmp_path / "new.toml")
    newer = read_log(tmp_path / "log.npz", tmp_path / "newer.toml")
    np.testing.assert_allclose(newer["motor.position.a"], -2.0 * made["motor.position.b"], rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[rewire]\nclock = 0", "clock"),
        ('[rewire."motor.positon"]\nfactor = [1, 1]', "no family of columns"),
        ('[rewire."motor.position"]\nfactors = [1, 1]', "Unknown key 'factors'"),
        ('[rewire."motor.position"]\nfactor = [1, 0]', "must not be zero"),
        ('[rewire."motor.position"]\nsource = [1, 1]', "each number from 0 to 1 once"),
        ('[rewire."motor.position"]\nsource = [1, 0]\nfactor = [1]', "one length"),
    ],
)
def test_corrections_that_say_nothing_clear_are_refused(text, message):
    with pytest.raises(FFGymError, match=message):
        parse_columns(text)


def test_corrections_for_another_number_of_joints_are_refused():
    with pytest.raises(FFGymError, match="are for 3 columns, the recording has 2"):
        Rewiring(families={"motor.position": Rewire.none(3).scale_parts([0], [-1.0])}).apply(recording())

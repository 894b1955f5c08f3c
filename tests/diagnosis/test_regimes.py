"""Maps and means of residuals show what was put in, where it was put in, and nothing elsewhere."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.profiles import VARIABLES, compute_profiles
from ffgym.diagnosis.regimes import REGIMES, collect_rows, map_by_motion, map_by_regime
from tests.diagnosis.residual_samples import made_up


def only(joint, values):
    """The values on one joint, nothing on others."""
    chosen = np.zeros_like(values)
    chosen[:, joint] = values[:, joint]
    return chosen


def column(regimes, place):
    return regimes.ratio[:, regimes.places.index(place)]


def test_noise_alone_stands_at_its_floor_everywhere(irb4600):
    residual = made_up(irb4600, {})
    for found in (map_by_regime(residual, "torque"), map_by_motion(residual, "torque")):
        seen = found.ratio[~np.isnan(found.ratio)]
        assert seen.size > 6
        assert np.abs(seen - 1).max() < 0.35  # 20 rows and more


def worst(found):
    """Component and place with the largest residual over noise floor."""
    component, place = np.unravel_index(np.nanargmax(found.ratio), found.ratio.shape)
    return found.components[component], found.places[place]


def test_every_row_is_in_exactly_one_regime_of_motion(irb4600):
    found = map_by_regime(made_up(irb4600, {}), "torque")
    motion = [i for i, group in enumerate(found.groups) if group == "motion"]
    counting = 3 * (1500 - 20)
    np.testing.assert_array_equal(found.rows[:, motion].sum(axis=1), counting)
    assert (found.rows[:, motion] > 0).all(axis=0).sum() == len(REGIMES["motion"])


def test_viscous_friction_shows_where_motors_are_fast(irb4600):
    residual = made_up(irb4600, {"torque": lambda state, travel: only(2, 0.02 * state.motor_speed)})
    found = map_by_regime(residual, "torque")
    assert worst(found) == ("j3", "fast")
    assert column(found, "rest")[2] < 1.5
    others = found.ratio[[0, 1, 3, 4, 5]]
    assert np.nanmax(others) < 1.35
    assert worst(map_by_motion(residual, "torque")) == ("j3", "fast")


def test_a_fault_that_follows_reversals_shows_there(irb4600):
    bristle = irb4600.friction.static / irb4600.friction.bristle_stiffness
    residual = made_up(
        irb4600,
        {"torque": lambda state, travel: only(0, 0.1 * np.exp(-travel / bristle) * (np.abs(state.motor_speed) > 0.05))},
    )
    found = map_by_regime(residual, "torque")
    assert column(found, "presliding")[0] > 3 * column(found, "mid")[0]
    assert column(found, "reversal")[0] < column(found, "presliding")[0]


def test_a_warm_machine_differs_in_warm_rows(irb4600):
    residual = made_up(irb4600, {"torque": lambda state, travel: only(1, 0.01 * (state.temperature - 20.0))})
    found = map_by_regime(residual, "torque")
    assert column(found, "warm")[1] > 2 * column(found, "cool")[1]


def test_a_tool_has_motions_but_no_regimes(irb4600):
    residual = made_up(irb4600, {}, channels=("torque", "tool"))
    assert map_by_motion(residual, "tool").components == ("x", "y", "z")
    with pytest.raises(FFGymError, match="no regimes"):
        map_by_regime(residual, "tool")


def test_means_over_position_tell_a_sign_locked_fault_from_one_that_is_not(irb4600):
    locked = made_up(
        irb4600, {"torque": lambda s, _: only(0, 0.05 * np.sign(s.motor_speed) * np.sin(200 * s.joint_angle))}
    )
    free = made_up(irb4600, {"torque": lambda s, _: only(0, 0.05 * np.sin(200 * s.joint_angle))})
    for residual, sign in ((locked, -1), (free, 1)):
        found = compute_profiles(collect_rows(residual, "torque"), 0, 0, VARIABLES["position"])
        back = np.interp(found["forwards"].centre, found["back"].centre, found["back"].mean)
        assert np.corrcoef(found["forwards"].mean, back)[0, 1] * sign > 0.5


def test_the_band_of_a_mean_of_noise_holds_zero_as_often_as_it_says(irb4600):
    inside = []
    for seed in range(4):
        rows = collect_rows(made_up(irb4600, {}, seed=seed), "torque")
        for j in range(6):
            found = compute_profiles(rows, j, j, VARIABLES["speed"])["both"]
            known = ~np.isnan(found.error)
            inside += list((found.low[known] < 0) & (found.high[known] > 0))
    assert 0.88 < np.mean(inside) < 0.99


def test_the_band_knows_that_rows_of_a_block_say_the_same(irb4600):
    drifting = made_up(irb4600, {"torque": lambda state, _: 0.05 * np.sin(2 * np.pi * np.floor(state.time) * 0.37)})
    found = compute_profiles(collect_rows(drifting, "torque"), 0, 0, VARIABLES["time"])
    slow = compute_profiles(collect_rows(drifting, "torque"), 0, 0, VARIABLES["speed"])["both"]
    assert np.nanmean(slow.error) > 3 * 0.05 / np.sqrt(2 * 185)  # what independent rows would say
    assert found.keys() == {"forwards", "back"}


def test_what_never_changes_has_no_profile(irb4600):
    residual = made_up(irb4600, {})
    rows = collect_rows(residual, "torque")
    rows.temperature.setflags(write=True)
    rows.temperature[:] = 20.0
    assert compute_profiles(rows, 0, 0, VARIABLES["temperature"])["forwards"].mean.size == 0


def test_rows_after_the_last_that_counts_are_no_part_of_the_log(irb4600):
    residual = made_up(irb4600, {})
    residual.motions[1].valid[700:] = False  # a motion that is padded to the length of others
    rows = collect_rows(residual, "torque")
    assert np.bincount(rows.motion).tolist() == [1490, 700, 1490]
    assert (np.diff(rows.time) >= 0).all()
    np.testing.assert_allclose(rows.time[-1], (1489 + 699 + 1489) * 0.008)

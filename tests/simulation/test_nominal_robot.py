"""The built-in six-axis robot on the circle test: what the thesis saw on its robot."""

import numpy as np
import pytest

from ffgym.published import published_mm
from ffgym.studies import circle_references, circle_study

POSITIONS = ("p1", "p2", "p3", "p4")
LAWS = ("none", "lugre_static", "lugre_dynamic")


@pytest.fixture(scope="module")
def study(irb4600):
    return circle_study(irb4600, positions=POSITIONS)


def mean_rms(study, **wanted):
    cells = study.select(**wanted)
    assert cells
    return float(np.mean([cell.rms_mm for cell in cells]))


@pytest.mark.parametrize("position", POSITIONS)
def test_at_10_mm_s_dynamic_beats_static_beats_none(study, position):
    none, static, dynamic = (mean_rms(study, agent=law, speed_mm_s=10.0, position=position) for law in LAWS)
    assert dynamic < static < none


def test_at_10_mm_s_ideal_dynamic_compensation_leaves_little(study):
    assert mean_rms(study, agent="lugre_dynamic", speed_mm_s=10.0) < 0.1 * mean_rms(
        study, agent="none", speed_mm_s=10.0
    )


def test_at_40_mm_s_the_smallest_circle_keeps_a_large_error_under_dynamic_compensation(study):
    assert mean_rms(study, agent="lugre_dynamic", speed_mm_s=40.0, radius_mm=1.0) > 0.15


def test_at_100_mm_s_a_large_error_stays_under_dynamic_compensation(study):
    fast = mean_rms(study, agent="lugre_dynamic", speed_mm_s=100.0)
    assert fast > 0.15
    assert fast > 3 * mean_rms(study, agent="lugre_dynamic", speed_mm_s=10.0)


def test_motors_reach_20_rad_s_at_100_mm_s_and_joint_3_is_the_fastest(arm):
    references = circle_references(arm, POSITIONS, [0.1])
    peaks = np.max([np.abs(reference.motor_dq).max(axis=0) for reference in references.values()], axis=0)
    assert 18 <= peaks.max() <= 22
    assert int(np.argmax(peaks)) == 2
    seen = {p: np.abs(references[p, 0.1].motor_dq[:, 2]).max() for p in POSITIONS}
    assert max(seen.values()) == peaks[2]


def test_simulated_motors_reach_the_speed_of_their_reference(study):
    recordings = [study.recordings["none", p, 0.1] for p in POSITIONS]
    peak = max(np.abs(r.joint_array("motor.velocity")[:, 2]).max() for r in recordings)
    assert 18 <= peak <= 24


def test_compensation_never_saturates_the_drives_up_to_40_mm_s(study):
    for (_, _, speed), recording in study.recordings.items():
        if speed <= 0.04:
            np.testing.assert_array_equal(
                recording.joint_array("motor.effort"), recording.joint_array("command.effort")
            )


def published_ratios(study, speed):
    """Simulated over published RMS without compensation, one per radius and position."""
    return np.array(
        [
            cell.rms_mm / published_mm("none", "rms", speed, cell.radius_mm * 1e-3, cell.position)
            for cell in study.select(agent="none", speed_mm_s=speed * 1e3)
        ]
    )


def test_uncompensated_error_is_within_half_of_the_published_one_in_most_cells(study):
    ratios = np.concatenate([published_ratios(study, speed) for speed in (0.01, 0.04)])
    assert len(ratios) == 24
    close = (ratios > 1 / 1.5) & (ratios < 1.5)
    assert close.sum() >= 18, f"{close.sum()} of 24 cells; ratios {np.round(ratios, 2).tolist()}"


@pytest.mark.parametrize("speed", [0.01, 0.04])
def test_median_uncompensated_error_is_the_published_one(study, speed):
    assert 0.8 <= np.median(published_ratios(study, speed)) <= 1.25


def test_every_circle_has_one_cell_per_law(study):
    assert len(study.cells) == 3 * 4 * 3 * 3
    keys = {(c.agent, c.position, c.radius_mm, c.speed_mm_s) for c in study.cells}
    assert len(keys) == len(study.cells)

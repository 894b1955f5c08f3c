"""Nominal models fitted to the logs that are diagnosed."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.held_out import compare_replays
from ffgym.diagnosis.nominal import choose_filtering, fit_nominal
from ffgym.diagnosis.procedure import examine
from ffgym.diagnosis.settings import settings
from ffgym.robot import RigidArm, load_draft, load_robot, motor_torque
from tests.diagnosis.identification.rigid_body.recorded_arms import mistaken, recorded, rigid, swing


@pytest.fixture(scope="module")
def two_link():
    return rigid(load_robot("two_link"))


@pytest.fixture(scope="module")
def paths(two_link):
    return [swing(two_link, seed, duration=12.0) for seed in (1, 2)]


@pytest.fixture(scope="module")
def recordings(two_link, paths):
    return [recorded(two_link, path, noise=0.01, seed=i, segment=f"m{i}") for i, path in enumerate(paths)]


def left(machine, recording, path):
    """RMS of what a machine leaves of the torque while all motors move, as a share of it, (N,)."""
    torque = recording.joint_array("motor.effort")
    moving = np.all(np.abs(path.dq) > 0.05, axis=1)
    residual = torque - motor_torque(RigidArm(machine.robot), path.q, path.dq, path.ddq).total
    return np.sqrt(np.mean(residual[moving] ** 2, axis=0) / np.mean(torque[moving] ** 2, axis=0))


def test_wrong_numbers_of_a_description_are_replaced_by_those_that_the_logs_tell(two_link, paths, recordings):
    wrong = mistaken(two_link)
    machine, prior = fit_nominal(wrong, recordings)
    for recording, path in zip(recordings, paths, strict=True):
        assert np.all(left(machine, recording, path) < 0.03)
        assert np.all(left(replace(machine, robot=wrong), recording, path) > 0.1)
    assert prior.share == settings().prior.fitted_share
    assert machine.effects == ()


def test_masses_need_not_be_known_at_all(two_link, paths, recordings):
    draft = load_draft("two_link")
    known = ("kinematics.", "drive.gear_ratio", "simulation.gravity")
    draft = replace(draft, quantities={k: v for k, v in draft.quantities.items() if k.startswith(known)})
    machine, _ = fit_nominal(draft, recordings)
    assert np.all(left(machine, recordings[0], paths[0]) < 0.05)


def test_numbers_that_blocks_of_a_log_disagree_about_are_less_sure(two_link, paths):
    """Friction that is other in each second widens its interval, and so what calibration leaves open."""
    wild = np.random.default_rng(0).normal(size=(13, 2)) * 30 * two_link.friction.coulomb

    def extra(path):
        return wild[(path.t + 1e-9).astype(int)] * np.sign(path.dq)

    noisy = [recorded(two_link, path, extra=extra, segment=f"m{i}") for i, path in enumerate(paths)]
    _, prior = fit_nominal(two_link, noisy)
    assert prior.share > 2 * settings().prior.fitted_share


def test_filters_fit_slow_logs_and_joints_that_bend(two_link, recordings):
    elastic = load_robot("two_link")
    assert choose_filtering(elastic, recordings).parallel.cutoff == 5.0
    assert choose_filtering(two_link, recordings).parallel.cutoff > 5.0
    slow = [replace_rows(recording, 25) for recording in recordings]
    machine, _ = fit_nominal(two_link, slow)
    np.testing.assert_allclose(machine.robot.friction.viscous, two_link.friction.viscous, rtol=0.1)


def replace_rows(recording, stride):
    """Every so many rows of a recording."""
    return type(recording)({c: v[::stride] for c, v in recording.columns.items()}, recording.header)


def test_there_must_be_recordings(two_link):
    with pytest.raises(FFGymError, match="no recordings"):
        fit_nominal(two_link, [])


def test_masses_that_made_up_for_a_late_torque_are_fitted_anew_to_torque_in_step(two_link, paths, recordings):
    """Rows of 10 Hz with the torque of the row before; the model that is written foretells another motion."""
    late = [late_rows(recording, 25) for recording in recordings]
    machine, prior = fit_nominal(two_link, late)
    examined = examine(machine, late, prior=prior)
    assert [cause.effect for cause in examined.diagnosis.causes] == ["torque_clock"]
    path = swing(two_link, 3, duration=12.0)
    other = late_rows(recorded(two_link, path, noise=0.01, seed=3, segment="other"), 25)
    levels = compare_replays(machine, examined.machine, [other])
    assert all(level.after < 0.5 * level.before for level in levels), levels


def late_rows(recording, stride):
    """Every so many rows of a recording, each with the torque of the row before."""
    columns = {c: v[::stride][1:] for c, v in recording.columns.items()}
    columns |= {c: v[::stride][:-1] for c, v in recording.columns.items() if c.startswith("motor.effort")}
    return type(recording)(columns, recording.header)

"""A known truth comes out within its interval; what a motion does not tell stays as described, and is named."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.parameter_file import parameter_text
from ffgym.diagnosis.identification.rigid_body import Filtering, RigidBodyOptions, identify_rigid_body
from ffgym.diagnosis.identification.rigid_body.terms import DEFAULT_TERMS
from ffgym.diagnosis.identification.rigid_body.unknown import starting_robot
from ffgym.logs.preparation import LowPass
from ffgym.robot import load_draft, load_robot, with_parameters
from tests.diagnosis.identification.rigid_body.recorded_arms import mistaken, recorded, rigid, simulated, swing
from tests.robot.arm_samples import random_arm, scara
from tests.robot.robot_samples import unusual

FEW = RigidBodyOptions(resamples=20)


@pytest.fixture(scope="module")
def two_link():
    return rigid(load_robot("two_link"))


@pytest.fixture(scope="module")
def paths(two_link):
    return [swing(two_link, seed) for seed in (1, 2, 3)]


def truth(fit, robot):
    return fit.base.values(np.concatenate([term.described(robot) for term in fit.terms]))


def coverage(robot, paths, repetitions):
    """Share of base parameters within their 90 % intervals, over repetitions of the noise."""
    inside = []
    for seed in range(repetitions):
        recordings = [recorded(robot, path, noise=0.02, seed=10 * seed + i) for i, path in enumerate(paths)]
        fit = identify_rigid_body(mistaken(robot), recordings, RigidBodyOptions(resamples=60, seed=seed))
        low, high = fit.base_intervals.low, fit.base_intervals.high
        inside.append((low <= truth(fit, robot)) & (truth(fit, robot) <= high))
    return np.mean(inside)


def test_intervals_cover_the_truth(two_link, paths):
    assert 0.75 <= coverage(two_link, paths[:2], repetitions=10) <= 0.99


@pytest.mark.slow
def test_intervals_of_90_percent_cover_the_truth_in_80_to_98_percent_of_50_repetitions(two_link, paths):
    assert 0.80 <= coverage(two_link, paths[:2], repetitions=50) <= 0.98


def test_without_noise_all_that_torque_tells_is_found(two_link, paths):
    fit = identify_rigid_body(mistaken(two_link), [recorded(two_link, path) for path in paths[:2]], FEW)
    found, wanted = fit.base.values(fit.estimate), truth(fit, two_link)
    np.testing.assert_allclose(found, wanted, atol=2e-3 * np.abs(wanted).max())
    assert fit.of("coulomb.elbow") == pytest.approx(two_link.friction.coulomb[1], rel=0.01)
    found, before = fit.identified.friction, mistaken(two_link).friction
    np.testing.assert_allclose(found.static / found.coulomb, before.static / before.coulomb)
    errors = fit.validate([recorded(two_link, paths[2])])
    assert np.all(errors.identified < 0.003 * errors.measured)
    assert np.all(errors.described > 0.1 * errors.measured)


def test_couplings_rails_and_springs_are_the_descriptions(irb4600):
    """Six axes on a rail with a coupled wrist and a counterbalance; the masses are mistaken."""
    robot = rigid(unusual(irb4600))
    recordings = [recorded(robot, swing(robot, seed, duration=12.0)) for seed in (1, 2)]
    fit = identify_rigid_body(mistaken(robot), recordings[:1], RigidBodyOptions(resamples=2, spread=1.0))
    errors = fit.validate(recordings[1:])
    assert np.all(errors.identified < 0.02 * errors.measured)
    assert np.all(errors.described > 0.05 * errors.measured)


def test_a_spring_is_fitted_when_asked_for(irb4600):
    robot = rigid(unusual(irb4600))
    soft = replace(
        robot, springs=(replace(robot.springs[0], stiffness=tuple(0.8 * np.array(robot.springs[0].stiffness))),)
    )
    recording = recorded(robot, swing(robot, 1, duration=12.0))
    options = RigidBodyOptions(terms=(*DEFAULT_TERMS, "springs"), resamples=2, spread=0.3)
    assert identify_rigid_body(soft, [recording], options).of("springs.balance") == pytest.approx(1 / 0.8, rel=0.02)


@pytest.mark.parametrize("seed", range(4))
def test_bodies_always_exist_however_poor_the_motion_and_wrong_the_description(seed, tmp_path):
    """Noise as large as the torque, one joint that hardly moves, masses off by a factor of three."""
    robot = rigid(random_arm("RRPR", seed))
    path = swing(robot, seed, duration=12.0)
    still = np.array([1.0, 1.0, 0.01, 1.0])
    path = replace(path, q=path.q * still, dq=path.dq * still, ddq=path.ddq * still)
    described = mistaken(robot, size=1.0, seed=seed)
    fit = identify_rigid_body(described, [recorded(robot, path, noise=1.0)], RigidBodyOptions(resamples=2, spread=10.0))
    found = fit.identified  # which is checked when it is made
    (tmp_path / "parameters.toml").write_text(parameter_text(described, fit.quantities, "poor"), encoding="utf-8")
    read = with_parameters(described, tmp_path / "parameters.toml")
    np.testing.assert_array_equal(read.bodies.inertia, found.bodies.inertia)
    np.testing.assert_array_equal(read.tool.inertia, found.tool.inertia)
    np.testing.assert_array_equal(read.friction.static, found.friction.static)


def test_a_good_description_is_kept_and_a_bad_one_left(two_link, paths):
    recordings = [recorded(two_link, path, noise=0.02, seed=i) for i, path in enumerate(paths[:2])]
    good = identify_rigid_body(two_link, recordings, FEW)
    bad = identify_rigid_body(mistaken(two_link, size=0.6), recordings, FEW)
    assert good.trade_off.chosen < 0.01 < bad.trade_off.chosen
    assert np.mean(good.base_shares) < np.mean(bad.base_shares)


def test_a_joint_that_stands_still_stays_as_described_and_is_named(two_link, paths):
    still = np.array([1.0, 0.0])
    path = replace(paths[0], q=paths[0].q * still, dq=paths[0].dq * still, ddq=paths[0].ddq * still)
    described = mistaken(two_link)
    fit = identify_rigid_body(described, [recorded(two_link, path)], FEW)
    assert fit.not_excited == ("coulomb.elbow", "viscous.elbow", "offset.elbow")
    assert fit.of("coulomb.elbow") == described.friction.coulomb[1]
    assert fit.shares[fit.labels.index("rotor_inertia.elbow")] < 0.1
    assert fit.of("coulomb.shoulder") == pytest.approx(two_link.friction.coulomb[0], rel=0.02)


def test_where_the_data_are_silent_intervals_are_as_wide_as_the_spread(two_link, paths):
    still = np.array([1.0, 0.0])
    path = replace(paths[0], q=paths[0].q * still, dq=paths[0].dq * still, ddq=paths[0].ddq * still)
    fit = identify_rigid_body(two_link, [recorded(two_link, path)], RigidBodyOptions(resamples=300, spread=0.1))
    i = fit.labels.index("rotor_inertia.elbow")
    half = (fit.intervals.high[i] - fit.intervals.low[i]) / (2 * fit.described[i])
    assert half == pytest.approx(1.645 * 0.1, rel=0.15)


def test_an_offset_is_not_told_from_friction_by_a_motion_in_one_direction():
    """A vertical axis that only ever turns forwards."""
    robot = rigid(load_robot("one_axis"))
    path = swing(robot, 0, duration=10.0)
    fast = 1.2 * np.abs(path.dq).max()
    path = replace(path, q=path.q + fast * path.t[:, None], dq=path.dq + fast)
    fit = identify_rigid_body(mistaken(robot), [recorded(robot, path, noise=0.01)], RigidBodyOptions(resamples=2))
    assert "offset.j1" in fit.not_excited
    assert fit.of("coulomb.j1") == pytest.approx(robot.friction.coulomb[0], rel=0.2)


def test_asymmetry_and_offsets_are_found_and_the_file_says_what_it_can(two_link, paths):
    def extra(path):
        return np.array([0.2, -0.1]) + np.array([0.002, 0.001]) * np.abs(two_link.drive.motor_angle(path.dq))

    recordings = [recorded(two_link, path, noise=0.01, seed=1, extra=extra) for path in paths[:2]]
    options = RigidBodyOptions(terms=(*DEFAULT_TERMS, "viscous_asymmetry"), resamples=20)
    fit = identify_rigid_body(two_link, recordings, options)
    assert fit.of("offset.shoulder") == pytest.approx(0.2, abs=0.05)
    assert fit.of("viscous_asymmetry.elbow") == pytest.approx(0.001, rel=0.1)
    assert not any("offset" in path for path in fit.quantities)
    assert np.all(fit.errors.in_file > fit.errors.identified)


@pytest.mark.parametrize("make", [scara, lambda: load_robot("two_link")], ids=["scara", "two_link"])
def test_a_simulated_machine_is_predicted_on_motions_it_was_not_fitted_to(make):
    """Elastic joints, LuGre friction, resolvers, noise on the torque; masses, rotors and friction are mistaken."""
    robot = make()
    recordings = simulated(robot, seeds=(1, 2))
    fit = identify_rigid_body(mistaken(robot), recordings[:1], FEW)
    errors = fit.validate(recordings[1:])
    assert np.all(errors.identified < 0.35 * errors.described)
    assert np.all(errors.in_file < 0.35 * errors.described)
    np.testing.assert_allclose(fit.identified.friction.viscous, robot.friction.viscous, rtol=0.05)


@pytest.mark.slow
def test_a_simulated_six_axis_robot_is_identified_to_a_percent(irb4600):
    recordings = simulated(irb4600, seeds=(1, 2, 3))
    fit = identify_rigid_body(mistaken(irb4600), recordings[:2], FEW)
    errors = fit.validate(recordings[2:])
    assert np.all(errors.in_file < 0.02 * errors.measured)
    assert np.all(errors.in_file < 0.1 * errors.described)
    np.testing.assert_allclose(fit.identified.friction.coulomb, irb4600.friction.coulomb, rtol=0.05)


def test_a_robot_of_unknown_masses_is_predicted_from_its_geometry(two_link, paths):
    draft = load_draft("two_link")
    known = ("kinematics.", "drive.gear_ratio", "simulation.gravity")
    draft = replace(draft, quantities={k: v for k, v in draft.quantities.items() if k.startswith(known)})
    recordings = [recorded(two_link, path, noise=0.01, seed=i) for i, path in enumerate(paths[:2])]
    fit = identify_rigid_body(starting_robot(draft, recordings), recordings, FEW)
    errors = fit.validate([recorded(two_link, paths[2])])
    assert np.all(errors.in_file < 0.02 * errors.measured)
    assert "rule of thumb" in fit.quantities["links.mass"].prior_source


def test_the_same_seed_gives_the_same_numbers(two_link, paths):
    recording = recorded(two_link, paths[0], noise=0.05)
    first, second = (identify_rigid_body(two_link, [recording], FEW) for _ in range(2))
    np.testing.assert_array_equal(first.resampled, second.resampled)


def test_what_cannot_be_identified_is_one_error(two_link, paths):
    recording = recorded(two_link, paths[0])
    rest = replace(paths[0], dq=0 * paths[0].dq, ddq=0 * paths[0].ddq, q=np.tile(paths[0].q[:1], (len(paths[0].t), 1)))
    nameless = replace(recording, header=replace(recording.header, torque_semantics="unspecified"))
    cases = {
        "no recordings": [],
        "No motor moves": [recorded(two_link, rest)],
        "torque_semantics": [nameless],
        "hold": [replace(recording, header=replace(recording.header, hold="unspecified"))],
        "blocks": [recording.slice(0.0, 3.0)],
    }
    for message, recordings in cases.items():
        with pytest.raises(FFGymError, match=message):
            identify_rigid_body(two_link, recordings, FEW)
    with pytest.raises(FFGymError, match="Unknown term 'mass'"):
        RigidBodyOptions(terms=("mass",))
    quick = replace(FEW, filtering=Filtering(motion=LowPass(cutoff=400.0)))
    with pytest.raises(FFGymError, match="low-pass"):
        identify_rigid_body(two_link, [recording], quick)

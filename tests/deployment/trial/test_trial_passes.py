"""Passes of a program in a log: found by the joints, whatever the clock and the ends of the log are."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.deployment.trial.passes import find_passes
from ffgym.deployment.trial.scoring import score_run
from tests.deployment.trial.trial_samples import Machine, make_program

PROGRAM = make_program()
MACHINE = Machine(scatter=0.0, lag=0.0)


def run(program=PROGRAM, machine=MACHINE, seed=0, **options):
    """Log of one run without correction."""
    return machine.run(program, False, rng=np.random.default_rng(seed), **options)


@pytest.mark.parametrize("dt", [0.001, 0.004, 0.02])
def test_a_pass_is_found_within_a_fraction_of_a_sample_on_any_clock(dt):
    machine = replace(MACHINE, dt=dt, wait=0.5017)
    (found,) = find_passes(PROGRAM, run(machine=machine, begin=1e4)).found
    assert found.start == pytest.approx(1e4 + 0.5017, abs=2e-4)


def test_every_lap_is_found():
    passes = find_passes(PROGRAM, run(laps=3)).found
    assert np.allclose([one.start for one in passes], 0.5 + PROGRAM.duration * np.arange(3), atol=1e-3)


def test_a_log_that_lacks_a_part_of_the_rests_still_has_its_pass():
    whole = run()
    (found,) = find_passes(PROGRAM, whole.slice(start=0.7, end=2.2)).found
    (full,) = find_passes(PROGRAM, whole).found
    assert found.start == pytest.approx(full.start, abs=1e-6)
    sizes = [score_run([one.recording], "tool").size for one in (found, full)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.02)


def test_another_speed_another_place_and_half_a_program_are_no_pass():
    for other in (make_program(speed=1.1), make_program(middle=0.52)):
        passes = find_passes(PROGRAM, run(other))
        assert not passes.found
        assert passes.nearest > 0.3 or passes.paces == pytest.approx([1.1], abs=0.01)
    assert find_passes(PROGRAM, run().slice(end=1.0)).nearest == np.inf


def test_set_points_and_tool_path_of_a_pass_are_those_of_the_program_not_of_the_log():
    (found,) = find_passes(PROGRAM, MACHINE.run(PROGRAM, True, rng=np.random.default_rng(0))).found
    recording = found.recording
    program = 100 * np.interp(recording.t, PROGRAM.recording.t, PROGRAM.joints[:, 0])
    assert np.allclose(recording["reference.position.j1"], program, atol=1e-3)
    assert np.allclose(recording.vector("tcp_reference.position"), PROGRAM.tool_path(recording.t))
    assert [phase.kind for phase in recording.header.phases] == ["standstill", "motion", "standstill"]


def test_the_error_of_a_pass_is_that_of_the_machine_without_the_noise_of_its_tracker():
    plain, noisy = (
        [
            score_run([one.recording], "tool")
            for seed in range(count)
            for one in find_passes(PROGRAM, run(machine=replace(MACHINE, noise=noise), seed=seed)).found
        ]
        for noise, count in ((1e-9, 1), (2e-5, 12))
    )
    assert plain[0].size == pytest.approx(100.0, rel=2e-3)  # um
    # noise of one axis and more would add 2 %; what is left is the offset at the start, known to 1.6 um
    assert np.mean([one.size for one in noisy]) == pytest.approx(100.0, rel=0.01)
    assert max(one.doubt for one in noisy) < 0.012


def test_passes_of_a_run_are_scored_together():
    pair = [
        find_passes(PROGRAM, run(machine=replace(MACHINE, without=size, noise=1e-9))).found[0].recording
        for size in (1e-4, 2e-4)
    ]
    one, two = (score_run([recording], "tool").size for recording in pair)
    assert score_run(pair, "tool").size == pytest.approx(np.sqrt((one**2 + two**2) / 2))


def test_a_log_without_joint_positions_or_with_other_joints_is_refused():
    log = run()
    bare = log.derive({name: log[name] for name in ("timestamp",)})
    with pytest.raises(FFGymError, match=r"no motor\.position"):
        find_passes(PROGRAM, bare)
    header = replace(log.header, joints=("j1",), gear_ratio=(100.0,), joint_types=("hinge",))
    one = log.derive({"timestamp": log.t, "motor.position.j1": log["motor.position.j1"]}, header)
    with pytest.raises(FFGymError, match="1 joints, the program has 2"):
        find_passes(PROGRAM, one)

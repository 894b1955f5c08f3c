"""The training loop: bookkeeping, locks, best weights, and going on after an interruption."""

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.law_files import pack, unpack
from ffgym.agents.lffc import LFFC, Learning, relative, robot_seconds
from ffgym.agents.trials import Lesson, SimulatedTrial, learning_signal
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.recordings.metrics import motor_error
from ffgym.robot import RigidArm

SHORT = 1.0
"""Duration of the sines here [s]."""


@pytest.fixture(scope="module")
def trial(one_axis):
    return SimulatedTrial(arm=RigidArm(one_axis), n_threads=1)


@pytest.fixture(scope="module")
def sines(one_axis):
    """A slow and a fast sine."""
    return [joint_reference(one_axis, joint_sine([1.0], f, SHORT, name=f"sine {f:g} Hz")) for f in (1.0, 2.0)]


@pytest.fixture(scope="module")
def learned(trial, sines):
    """Three updates from the slow sine."""
    return LFFC(rate=0.8, iterations=3).learn(StaticBSN.zero(1), sines[:1], trial)


class Remembering:
    """A trial that keeps what it was asked for and what came out."""

    def __init__(self, trial):
        self.trial, self.calls, self.recordings = trial, [], []

    def __call__(self, runs, number):
        self.calls.append((number, [run.law for run in runs]))
        self.recordings.append(self.trial(runs, number))
        return self.recordings[-1]


def test_errors_and_signal_of_every_trial_are_the_mean_squares_of_its_recordings(trial, sines):
    watched = Remembering(trial)
    learning = LFFC(rate=0.8, iterations=2).learn(StaticBSN.zero(1), sines, watched)
    assert learning.error.shape == learning.signal.shape == (3, 2, 1)
    for k, recordings in enumerate(watched.recordings):
        for m, recording in enumerate(recordings):
            rows = recording.t < SHORT  # the last sample ends the motion
            error, u_p = motor_error(recording)[rows], learning_signal(recording, sines[0].robot)[rows]
            np.testing.assert_allclose(learning.error[k, m], np.mean(error**2, axis=0), rtol=1e-12)
            np.testing.assert_allclose(learning.signal[k, m], np.mean(u_p**2, axis=0), rtol=1e-12)


def test_iterations_are_updates_and_the_last_one_is_tried_too(trial, sines):
    watched = Remembering(trial)
    learning = LFFC(rate=0.8, iterations=2).learn(StaticBSN.zero(1), sines[:1], watched)
    assert [number for number, _ in watched.calls] == [0, 1, 2]
    assert learning.trials == 3
    assert not watched.calls[0][1][0].coefficients.any()
    assert robot_seconds(sines[:1], learning.trials) == pytest.approx(3 * SHORT)


def test_a_trial_runs_the_network_that_the_last_one_taught(trial, sines):
    watched = Remembering(trial)
    LFFC(rate=0.6, iterations=2, signal="u_c").learn(ExtendedBSN.zero(1), sines, watched)
    for k in (0, 1):
        tried, following = watched.calls[k][1][0], watched.calls[k + 1][1][0]
        lessons = [Lesson.of(r, rec, "u_c") for r, rec in zip(sines, watched.recordings[k], strict=True)]
        np.testing.assert_array_equal(following.coefficients, tried.adapt(lessons, 0.6).coefficients)


@pytest.mark.parametrize("kind", ["u_p", "u_c", "e_p"])
def test_every_learning_signal_lowers_the_error(kind, trial, sines):
    learning = LFFC(rate=0.8, iterations=3, signal=kind).learn(StaticBSN.zero(1), sines[:1], trial)
    assert relative(learning.error)[-1, 0] < 0.5


def series(network, cost, z_cost, **options):
    """Learning after trials with these root mean squares of error and signal, (K, N) each; a lesson is one row."""
    learning = Learning.begin(network, 1)
    for e, z in zip(np.array(cost), np.array(z_cost), strict=True):
        one = Lesson(
            reference=None, t=np.zeros(1), q=np.zeros((1, len(e))),
            motor_dq=np.full((1, len(e)), 5.0), motor_ddq=np.ones((1, len(e))),
            signal=z[None], added=np.zeros((1, len(e))), error=e[None], moving=np.array([True]),
        )  # fmt: skip
        learning = learning.after([one], rate=0.5, **{"tolerance": 0.0, "patience": 2, **options})
    return learning


def weight(network, joint):
    """The weight of `joint` at 5 rad/s, where lessons of `series` are."""
    return float(network.torque_at(np.full(network.n_joints, 5.0), np.ones(network.n_joints))[joint])


def test_a_joint_is_locked_after_patience_trials_without_improvement_and_keeps_its_best_weights():
    error = [[4, 4], [3, 3], [3.5, 2], [3.6, 1], [9, 0.5]]
    learning = series(StaticBSN.zero(2), error, np.ones_like(error) * np.linspace(2, 1, 5)[:, None])
    assert learning.locked.tolist() == [True, False]
    assert learning.best_trial.tolist() == [1, 4]
    tried_first = 0.5 * 2.0  # after one update of rate 0.5 from a signal of 2
    assert weight(learning.best, 0) == pytest.approx(tried_first)
    assert weight(learning.network, 0) == pytest.approx(tried_first)
    assert weight(learning.network, 1) > weight(learning.best, 1) > tried_first


def test_a_joint_that_is_locked_stays_so_with_the_same_weights_whatever_its_errors_do_then():
    error = np.array([[4, 9], [5, 8], [6, 7], [3, 6], [1, 5]])
    learning = series(StaticBSN.zero(2), error, error)
    assert learning.locked.tolist() == [True, False]
    assert learning.best_trial.tolist() == [0, 4]
    assert weight(learning.network, 0) == weight(learning.best, 0) == 0


def test_improvement_needs_error_and_signal_to_fall():
    falling, flat = [[3.0], [2.0], [1.0]], [[1.0], [1.0], [1.0]]
    assert not series(StaticBSN.zero(1), falling, falling).locked.any()
    assert series(StaticBSN.zero(1), falling, flat).locked.all()
    assert series(StaticBSN.zero(1), flat, falling).locked.all()


def test_a_fall_within_the_tolerance_is_none():
    slow = [[1.0], [0.99], [0.98]]
    assert not series(StaticBSN.zero(1), slow, slow, tolerance=0.01).locked.any()
    assert series(StaticBSN.zero(1), slow, slow, tolerance=0.03).locked.all()


def test_one_better_trial_starts_patience_anew():
    error = [[4.0], [5.0], [3.0], [4.0]]
    assert not series(StaticBSN.zero(1), error, error).locked.any()


def test_motions_count_alike_whatever_the_size_of_their_errors():
    mean_square = np.array([[[1.0], [100.0]], [[0.5], [150.0]]])
    np.testing.assert_allclose(relative(mean_square), [[1.0], [(0.5 + 1.5) / 2]])


def test_a_joint_without_error_is_done_at_once_and_harms_nothing():
    learning = series(StaticBSN.zero(2), [[0, 4], [0, 3], [0, 2]], [[0, 4], [0, 3], [0, 2]])
    assert learning.locked.tolist() == [True, False]
    np.testing.assert_array_equal(relative(learning.error)[:, 0], 0)


def test_learning_ends_when_all_joints_are_done(trial, sines):
    learning = LFFC(rate=0.8, iterations=50, tolerance=0.9, patience=1).learn(StaticBSN.zero(1), sines[:1], trial)
    assert learning.trials == 2
    assert learning.locked.all()


def test_learning_again_gives_the_same_bits(trial, sines, learned):
    again = LFFC(rate=0.8, iterations=3).learn(StaticBSN.zero(1), sines[:1], trial)
    np.testing.assert_array_equal(again.best.coefficients, learned.best.coefficients)
    np.testing.assert_array_equal(again.error, learned.error)


def test_interrupted_learning_goes_on_to_the_same_bits(trial, sines, learned, tmp_path):
    state = tmp_path / "state.npz"

    class Stopped(Exception):
        pass

    def stop(learning, total):
        assert total == 4
        if learning.trials == 2:
            raise Stopped

    procedure = LFFC(rate=0.8, iterations=3)
    with pytest.raises(Stopped):
        procedure.learn(StaticBSN.zero(1), sines[:1], trial, state=state, watch=stop)
    watched = Remembering(trial)
    resumed = procedure.learn(StaticBSN.zero(1), sines[:1], watched, state=state)
    assert [number for number, _ in watched.calls] == [2, 3]
    for name in ("error", "signal", "best_trial", "stale", "locked"):
        np.testing.assert_array_equal(getattr(resumed, name), getattr(learned, name))
    np.testing.assert_array_equal(resumed.best.coefficients, learned.best.coefficients)
    np.testing.assert_array_equal(resumed.network.coefficients, learned.network.coefficients)


def test_a_killed_process_loses_no_more_than_its_last_trial(trial, sines, learned, tmp_path):
    """SIGKILL between two trials; nothing can be cleaned up."""
    script = textwrap.dedent(f"""
        import os, signal
        from pathlib import Path
        from ffgym.agents.bspline import StaticBSN
        from ffgym.agents.lffc import LFFC
        from ffgym.agents.trials import SimulatedTrial
        from ffgym.paths import joint_reference
        from ffgym.paths import joint_sine
        from ffgym.robot import RigidArm, load_robot
        robot = load_robot("one_axis")
        sine = joint_reference(robot, joint_sine([1.0], 1.0, {SHORT}, name="sine 1 Hz"))
        simulated = SimulatedTrial(arm=RigidArm(robot), n_threads=1)
        def trial(runs, number):
            if number == 2:
                os.kill(os.getpid(), signal.SIGKILL)
            return simulated(runs, number)
        LFFC(rate=0.8, iterations=3).learn(StaticBSN.zero(1), [sine], trial, state=Path("state.npz"))
    """)
    root = str(Path(__file__).parents[2])
    killed = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=os.environ | {"PYTHONPATH": root})
    assert killed.returncode == -signal.SIGKILL
    assert [p.name for p in tmp_path.iterdir()] == ["state.npz"]
    watched = Remembering(trial)
    resumed = LFFC(rate=0.8, iterations=3).learn(StaticBSN.zero(1), sines[:1], watched, state=tmp_path / "state.npz")
    assert len(watched.calls) == 2
    np.testing.assert_array_equal(resumed.best.coefficients, learned.best.coefficients)


@pytest.fixture
def state(trial, sines, tmp_path):
    """File of learning with one update."""
    path = tmp_path / "state.npz"
    LFFC(rate=0.8, iterations=1).learn(StaticBSN.zero(1), sines[:1], trial, state=path, machine="mine")
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"procedure": LFFC(rate=0.7, iterations=1)}, r"rate was 0.8, now 0.7\."),
        ({"procedure": LFFC(rate=0.8, iterations=1, signal="e_p")}, r"signal was 'u_p', now 'e_p'\."),
        ({"network": ExtendedBSN.zero(1)}, "network.kind was 'bsn_static'"),
        ({"network": StaticBSN.zero(1).with_curve(np.tanh)}, "first weights was '"),
        ({"motions": slice(1, 2)}, r"motions was \['sine 1 Hz'\], now \['sine 2 Hz'\]"),
        ({"machine": "another"}, r"machine was 'mine', now 'another'\."),
    ],
)
def test_learning_with_other_settings_is_not_resumed(change, message, state, trial, sines):
    procedure = change.get("procedure", LFFC(rate=0.8, iterations=1))
    network, motions = change.get("network", StaticBSN.zero(1)), sines[change.get("motions", slice(0, 1))]
    before = state.read_bytes()
    with pytest.raises(FFGymError, match=message):
        procedure.learn(network, motions, trial, state=state, machine=change.get("machine", "mine"))
    assert state.read_bytes() == before


def test_more_iterations_can_be_asked_for_later_but_not_fewer(state, trial, sines, learned):
    more = LFFC(rate=0.8, iterations=3).learn(StaticBSN.zero(1), sines[:1], trial, state=state, machine="mine")
    np.testing.assert_array_equal(more.error, learned.error)
    with pytest.raises(FFGymError, match="has 3 iterations already, more than the 2 asked for"):
        LFFC(rate=0.8, iterations=2).learn(StaticBSN.zero(1), sines[:1], trial, state=state, machine="mine")


def test_a_law_is_no_state_of_learning(trial, sines, tmp_path):
    from ffgym.agents.law_files import save_law

    path = save_law(tmp_path / "law.npz", StaticBSN.zero(1))
    with pytest.raises(FFGymError, match="kind 'bsn_static', not of learning"):
        LFFC().learn(StaticBSN.zero(1), sines[:1], trial, state=path)


@pytest.mark.parametrize("part", ["error", "signal", "best_trial", "stale", "locked", "network.coefficients"])
@pytest.mark.parametrize("change", [lambda x: None, lambda x: x[..., :0], lambda x: x * np.nan])
def test_a_state_that_lacks_something_or_holds_nonsense_is_one_clear_error(part, change, state, trial, sines):
    header, arrays = unpack(state)
    changed = {name: change(array) if name == part else array for name, array in arrays.items()}
    state.write_bytes(pack(header, {name: array for name, array in changed.items() if array is not None}))
    with pytest.raises(FFGymError, match=r"state\.npz: holds no complete learning: .*Begin anew with another file"):
        LFFC(rate=0.8, iterations=2).learn(StaticBSN.zero(1), sines[:1], trial, state=state, machine="mine")


def test_a_state_without_settings_is_not_resumed(state, trial, sines):
    header, arrays = unpack(state)
    state.write_bytes(pack(header | {"settings": [1]}, arrays))
    with pytest.raises(FFGymError, match=r"settings = \[1\] in its header must be an object"):
        LFFC(rate=0.8, iterations=2).learn(StaticBSN.zero(1), sines[:1], trial, state=state, machine="mine")


def test_learning_without_motion_or_for_another_robot_is_refused(trial, sines):
    with pytest.raises(FFGymError, match="no motion to learn from"):
        LFFC().learn(StaticBSN.zero(1), [], trial)
    with pytest.raises(FFGymError, match="for 6 joints does not fit"):
        LFFC().learn(StaticBSN.zero(6), sines, trial)


@pytest.mark.parametrize(
    "wrong",
    [{"rate": 0.0}, {"rate": float("nan")}, {"iterations": -1}, {"signal": "u"}, {"tolerance": -0.1}, {"patience": 0}],
)
def test_options_out_of_range_are_refused(wrong):
    with pytest.raises(FFGymError, match=next(iter(wrong))):
        LFFC(**wrong)

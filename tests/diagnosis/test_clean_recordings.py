"""What the nominal machine would have recorded along the motions of a log."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from ffgym.diagnosis.clean_recordings import make_clean_recordings
from ffgym.diagnosis.clean_replay import replay_finely
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.prepare import prepare
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.settings import use_settings
from ffgym.logs.preparation import differentiate
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm
from ffgym.simulation import Run, simulate
from tests.diagnosis.replay.replay_samples import nominal, recorded, reference


@pytest.fixture(scope="module")
def recording():
    """What the nominal machine recorded, with the columns that a log has."""
    one = recorded({"swing": nominal()})["swing"]
    families = ("timestamp", "motor.position", "motor.effort", "reference.position")
    return replace(one, columns={name: x for name, x in one.columns.items() if name.startswith(families)})


def at_times(recording, t):
    """The same motion, sampled at other times."""
    columns = {name: CubicSpline(recording.t, values)(t) for name, values in recording.columns.items()}
    return Recording(columns | {"timestamp": t}, replace(recording.header, phases=()))


def exact(recording):
    log = assemble_log(nominal().physical, [recording])
    return make_clean_recordings(log, replay(log, nominal()))


def test_what_a_machine_records_is_known_for_steps_of_no_length(recording):
    """The engine's recordings come as near as their steps are short: its error is of first order."""
    found = exact(recording)
    assert found.simulated
    angle, missed = found.recordings[0].joint_array("motor.position"), []
    for share in (1.0, 0.5, 0.25):
        options = ModelOptions(looks=False, physics_dt=share * nominal().robot.physics_dt)
        (own,) = simulate([Run(reference=reference())], machine=nominal(), options=options, record_dt=0.002)
        missed.append(np.abs(own.joint_array("motor.position") - angle).max())
    assert missed[0] < 2e-3
    assert missed[1] < 0.6 * missed[0]
    assert missed[2] < 0.6 * missed[1]


@pytest.mark.parametrize("period", [0.00199998, 0.0021, 0.005, 0.0004])
def test_clocks_of_real_machines_are_no_multiple_of_a_step(recording, period):
    """A clock that runs 10 ppm off, and periods that no simulation has."""
    log = at_times(recording, np.arange(0.0, recording.t[-1], period))
    found = exact(log)
    assert found.simulated
    again = found.recordings[0]
    inner = slice(1, len(again) - 1)
    np.testing.assert_allclose(again.t, log.t[: len(again)])
    assert log.t[-1] - again.t[-1] <= nominal().robot.servo.control_dt + period
    measured = log.joint_array("motor.position")[: len(again)]
    np.testing.assert_allclose(again.joint_array("motor.position")[inner], measured[inner], atol=2e-3)


@pytest.mark.parametrize("period", [0.005, 0.0075])
def test_between_samples_of_the_simulation_the_tool_is_where_the_links_hold_it(period):
    """At periods that no simulation has; a straight line between places would miss a bend of the path by 20 um."""
    whole = recorded({"swing": nominal()})["swing"]
    families = ("timestamp", "motor.position", "motor.effort", "reference.position", "tcp.position", "link.position")
    kept = replace(whole, columns={name: x for name, x in whole.columns.items() if name.startswith(families)})
    again = exact(at_times(kept, np.arange(0.0, whole.t[-1], period))).recordings[0]
    held = RigidArm(nominal().robot).tcp_position(again.joint_array("link.position"))
    np.testing.assert_allclose(again.vector("tcp.position")[1:-1], held[1:-1], atol=1e-7)


def test_a_motion_that_is_made_up_is_the_measured_one_once_it_went_through_the_low_pass(recording):
    """Motors that stop within milliseconds: smoothed again, they would turn back later than they do."""
    log = assemble_log(nominal().physical, [recording])
    stopped = np.maximum(log.q, np.quantile(log.q, 0.3, axis=0))
    low_pass = log.sampling.motion_filter
    smooth = np.stack([low_pass(stopped[:, 0], log.dt)], axis=1)
    dq, ddq = differentiate(smooth[:, 0], log.dt)
    log = replace(log, q=smooth, dq=dq[:, None], ddq=ddq[:, None], slip_dq=dq[:, None], trembling=0 * log.trembling)
    again = assemble_log(log.robot, replay_finely(log, replay(log, nominal())), like=log).q
    inner = slice(50, -50)
    twice = np.abs(low_pass(smooth[:, 0], log.dt) - smooth[:, 0])[inner].max()
    assert np.abs(again - smooth)[inner].max() < 0.4 * twice


def test_only_friction_needs_the_shortest_steps_of_a_fine_replay(recording):
    """Links and springs in steps twice as long give the torque of those in a quarter of one."""
    log = assemble_log(nominal().physical, [recording])
    run = replay(log, nominal())
    torque = replay_finely(log, run)[0].joint_array("motor.effort")
    with use_settings({"replay.link_step": 1e-9}):
        finest = replay_finely(log, run)[0].joint_array("motor.effort")
    assert 0 < np.abs(torque - finest).max() < 1e-3 * np.abs(finest).max()
    sampled = run.torque[: len(finest), 0]
    assert np.sqrt(np.mean((torque - finest) ** 2)) < 0.1 * np.sqrt(np.mean((sampled - finest) ** 2))


def test_vibration_in_a_wide_band_is_left_out_of_a_smooth_motion_and_kept_in_a_sharp_one(recording):
    """Angles that tremble at 60 Hz where 70 Hz are compared."""
    log = assemble_log(nominal().physical, [recording], cutoff=70.0)
    shaking = 1e-5 * np.sin(2 * np.pi * 60.0 * log.t)[:, None, None]
    log = replace(log, q=log.q + shaking, trembling=0 * log.trembling)
    run = replay(log, nominal())
    turn = np.exp(2j * np.pi * 60.0 * log.t[100:-100])[:, None]

    def of_vibration(smooth):
        angle = assemble_log(log.robot, replay_finely(log, run, smooth=smooth), like=log).recordings[0]
        moved = angle.joint_array("motor.position") / log.robot.drive.gear_ratio - log.q[:, 0] + shaking[:, 0]
        return 2 * np.abs(np.mean(turn * moved[100:-100], axis=0)) / 1e-5

    assert np.all(of_vibration(True) < 0.2)
    assert np.all(of_vibration(False) > 0.8)


def test_a_machine_under_another_controller_moves_as_measured(recording):
    """A lag of a quarter of a turn of the motor: what repeats with its turns would be out of phase."""
    names = [f"motor.position.{joint}" for joint in recording.header.joints]
    lag = {name: recording[name] + 1.5 * np.sin(3 * recording.t) for name in names}
    log = Recording(dict(recording.columns) | lag, recording.header)
    found = exact(log)
    assert not found.simulated
    moved = found.recordings[0].joint_array("motor.position")
    measured = log.joint_array("motor.position")
    assert np.abs(moved - measured)[100:-100].max() < 0.05
    ready = prepare(assemble_log(nominal().physical, [log]), nominal(), ParameterPrior(), np.random.default_rng(0))
    assert not ready.simulated


def test_motions_of_a_long_log_are_made_one_by_one_as_they_are_together(recording, monkeypatch):
    """All at once they would take memory for every motion; the shorter one is padded either way."""
    half = recording.slice(end=0.5 * float(recording.t[-1]))
    log = assemble_log(nominal().physical, [recording, replace(half, header=replace(half.header, segment="half"))])
    run, together = replay(log, nominal()), []
    for most in (1_000_000, 1):
        monkeypatch.setattr("ffgym.diagnosis.clean_replay._TOGETHER", most)
        together.append(replay_finely(log, run))
    for at_once, alone in zip(*together, strict=True):
        assert at_once.columns.keys() == alone.columns.keys()
        for name, values in at_once.columns.items():
            np.testing.assert_array_equal(alone[name], values)

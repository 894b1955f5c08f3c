"""Clean logs of an axis in continuous time: no step of our own engine, nor another controller, is taken for a fault."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis import diagnose
from ffgym.diagnosis.clean_recordings import FOREIGN, UNKNOWN, has_foreign_servo, make_clean_recordings
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.prepare import prepare
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import compute_residuals, find_valid_rows
from ffgym.recordings import Recording
from ffgym.simulation.plant import Machine
from tests.diagnosis.continuous_axis import Gains, recorded, sines
from tests.diagnosis.replay.replay_samples import nominal
from tests.diagnosis.replay.replay_samples import recorded as simulated

NOISE = (2e-5, 0.005)
EVERYTHING = ("reference", "feedback")
LEADING = Gains(lead=0.03)


@pytest.fixture(scope="module")
def logs(one_axis):
    """A function that records two motions."""

    def make(noise=None, seconds=8.0, **conditions):
        rng = np.random.default_rng(7)
        references = [sines(one_axis, phase, seconds) for phase in (0.0, 1.5)]
        return [recorded(one_axis, reference, noise=noise, rng=rng, **conditions) for reference in references]

    return make


def left(robot, recordings):
    """RMS of what replay leaves of recordings, and of that less the bias, by channel."""
    log, machine = assemble_log(robot, recordings), Machine(robot=robot)
    run = replay(log, machine)
    exact = make_clean_recordings(log, run)
    residual = compute_residuals(log, predict(run))
    own = assemble_log(robot, exact.recordings, like=log)
    bias, valid = compute_residuals(own, predict(replay(own, machine))), find_valid_rows(log)

    def rms(rows):
        return float(np.sqrt(np.mean(rows[valid] ** 2)))

    return exact, {channel: (rms(rows), rms(rows - bias[channel])) for channel, rows in residual.items()}


def test_the_bias_of_a_replay_is_that_against_continuous_time(one_axis, logs):
    """Of the engine's step, 0.004 N m of torque and 0.02 N m of the servo would be left."""
    exact, of = left(one_axis, logs(columns=EVERYTHING))
    assert exact.simulated
    assert of["torque"][1] < 0.1 * of["torque"][0]
    assert of["torque"][1] < 3e-4
    assert of["servo"][1] < 2e-4


def test_of_a_machine_that_moves_as_measured_too(one_axis, logs):
    exact, of = left(one_axis, logs())
    assert not exact.simulated
    assert of["torque"][1] < 0.5 * of["torque"][0]


@pytest.mark.parametrize(
    "conditions",
    [{"columns": EVERYTHING}, {}, {"columns": EVERYTHING, "gains": LEADING}],
    ids=["feedback torque", "no set-points", "set-points that lead"],
)
def test_nothing_is_found_in_clean_logs(conditions, one_axis, logs):
    found = diagnose(one_axis, logs(NOISE, **conditions))
    assert found.verdict == "none", found.sentence


def test_gains_that_are_others_are_named_to_a_per_cent(one_axis, logs):
    others = Gains(position=0.5, velocity=0.7, integral=0.3)
    found = diagnose(one_axis, logs(NOISE, columns=EVERYTHING, gains=others))
    assert [cause.effect for cause in found.causes] == ["servo_gains"]
    sizes = {size.name: size.value for size in found.causes[0].parameters}
    assert sizes == pytest.approx({"position": -0.5, "velocity": -0.3, "integral": -0.7}, abs=0.01)


@pytest.mark.parametrize(("is_described", "reason"), [(True, FOREIGN), (False, UNKNOWN)])
def test_the_torque_of_a_servo_that_nobody_described_is_not_compared(is_described, reason, one_axis, logs):
    known = one_axis.quantities
    if not is_described:
        known = {entry: quantity for entry, quantity in known.items() if not entry.startswith("servo.")}
    robot = replace(one_axis, quantities=known)
    log = assemble_log(robot, logs(NOISE, 4.0, columns=EVERYTHING, gains=LEADING if is_described else None))
    ready = prepare(log, Machine(robot=robot), ParameterPrior(), np.random.default_rng(0))
    assert ready.no_servo == reason
    assert not ready.simulated
    assert "servo" not in ready.floor


@pytest.mark.parametrize(
    ("gains", "limit", "is_foreign"),
    [
        (Gains(), np.inf, False),
        (Gains(position=0.5, velocity=0.7, integral=0.3), np.inf, False),
        (Gains(), 1.0, True),
    ],
    ids=["as documented", "other gains", "a limit of its own"],
)
def test_a_servo_is_foreign_if_no_gains_explain_its_torque(gains, limit, is_foreign, one_axis, logs):
    """Torque within a limit, a multiple of its RMS, correlates with the documented one: gains explain most of it."""
    limited = []
    for recording in logs(NOISE, 4.0, columns=EVERYTHING, gains=gains):
        torque = recording.columns["feedback.effort.j1"]
        most = limit * float(np.sqrt(np.mean(torque**2)))
        torque = np.clip(torque, -most, most)
        limited.append(Recording(dict(recording.columns) | {"feedback.effort.j1": torque}, recording.header))
    assert has_foreign_servo(assemble_log(one_axis, limited)) == is_foreign


def test_a_machine_that_moves_as_measured_has_all_channels():
    recording = simulated({"swing": nominal()})["swing"]
    lead = {
        name: np.interp(recording.t + 0.2, recording.t, values)
        for name, values in recording.columns.items()
        if name.startswith("reference.")
    }
    recording = Recording(dict(recording.columns) | lead, recording.header)
    exact, of = left(nominal().physical, [recording])
    assert not exact.simulated
    assert set(of) == {"torque", "tool", "link", "servo"}
    tool = exact.recordings[0].vector("tcp.position")
    np.testing.assert_allclose(tool, recording.vector("tcp.position"), atol=1e-4)

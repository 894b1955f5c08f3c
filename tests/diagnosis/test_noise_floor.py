"""How large residuals of a faultless machine are, motion by motion."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis import noise as module
from ffgym.diagnosis.fit.fit import evaluate, loudness, subtract_nuisances
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.noise import NullSimulation, estimate_noise, simulate_null_residuals
from ffgym.diagnosis.prepare import prepare, renew_floor
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.effects.transmission.arm_friction import ArmFriction
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import load_protocols, plan_session, record
from scripts.exam.independent.question import draw_task
from scripts.exam.independent.sensors import QUIET, TORQUE_NOISE, Columns


@pytest.mark.parametrize(("channel", "least"), [("torque", 0.3), ("servo", 1.0)])
def test_no_motion_has_much_less_noise_than_all_though_an_encoder_shows_none_while_it_stands(
    monkeypatch, channel, least
):
    """A thousand rows of motion with noise of 2, a thousand at rest without."""
    valid = np.ones((1000, 2), dtype=np.bool_)
    monkeypatch.setattr(module, "find_valid_rows", lambda log: valid)
    draws = np.zeros((1000, 2, 1, 1))
    draws[:, 0] = 2.0
    floor = NullSimulation(draws={channel: draws}).floor(SimpleNamespace())[channel]
    overall = np.sqrt(2.0)
    assert floor[0, 0] == pytest.approx(2.0)
    assert floor[1, 0] == pytest.approx(least * overall)


@pytest.mark.parametrize("row_dt", [pytest.param(0.002, marks=pytest.mark.slow), 0.01])
def test_what_a_model_foretells_above_the_band_of_motions_is_no_noise(row_dt):
    """Quiet sensors of a rigid arm that reverses: its torque has more above 38 Hz than their noise."""
    plain = Columns(tracker=False, set_points=False, feedback=False, speed=False, temperature=False)
    task = draw_task(
        "clean", 0, seed=4, n=2, elastic=False, noise="quiet", row_dt=row_dt, control="documented", columns=plain
    )
    run = replay(assemble_log(task.robot, task.log), Machine.of(task.robot))
    true = QUIET * TORQUE_NOISE * task.robot.friction.coulomb
    assert np.median(estimate_noise(run).torque / true) < 2.0


def test_of_the_floor_sensors_have_what_no_model_is_allowed_for():
    faultless = NullSimulation(draws={}, least={"torque": np.array([3.0])})
    floor = {"torque": np.full((2, 1), 5.0), "tool": np.ones((2, 3))}
    assert faultless.sensor_share(("torque", 0), floor) == pytest.approx(16 / 25)
    assert faultless.sensor_share(("tool", 2), floor) == 1.0


def test_without_sensors_arm_positions_are_known_to_some_per_mille_of_what_torques_bend(arm):
    """Positions of an exact recording: their noise is 0, but springs bend by torques that no model foretells."""
    rig = SimulatedRig(arm=arm, machine=Machine(robot=arm.robot), sensors=(), name="exact")
    motions = plan_session(arm, tuple(load_protocols("dwell_restart")))
    log = assemble_log(arm.robot, list(record(motions, rig, seed=0, record_dt=0.002, n_threads=1)))
    run = replay(log, rig.machine)
    bias = {channel: np.zeros_like(rows) for channel, rows in predict(run).items()}
    least = simulate_null_residuals(log, run, bias, run, np.random.default_rng(0)).least
    # what was recorded, without springs of any model: against where rigid joints would have links and tool
    bent = {"link": log.link - log.q, "tool": log.tool[:, 0] - arm.tcp_position(log.q[:, 0])}
    for channel, values in bent.items():
        rows = log.sampling(values.reshape(len(log.q), 1, -1))[find_valid_rows(log)]
        np.testing.assert_allclose(least[channel], 0.002 * rows.std(axis=0), rtol=0.03, err_msg=channel)


@pytest.fixture(scope="module")
def coloured():
    """Search for 0.89 of the friction behind the spring of one joint, in sensors whose noise stays for 6 ms."""
    task = draw_task("arm", 2, seed=42)
    log, machine = assemble_log(task.robot, task.log), Machine.of(task.robot)
    return prepare(log, machine, task.prior, np.random.default_rng(0))


def test_noise_that_stays_is_as_loud_as_it_is_in_what_causes_leave(coloured):
    """Noise of the tool has more energy in the band than above it, which friction behind the spring hides."""
    cause = Hypothesis(kind=ArmFriction, joint="a1", source=None, values={"share": np.array(0.89)})
    explained = evaluate(coloured.problem, (cause,))
    renewed = renew_floor(coloured, explained.run, np.random.default_rng(0))
    before, after = (
        loudness(ready.problem, subtract_nuisances(ready.problem, explained)) for ready in (coloured, renewed)
    )
    tool = [("tool", axis) for axis in range(3)]
    assert all(after[axis] < 0.7 * before[axis] for axis in tool)
    assert [after[axis] for axis in tool[:2]] == pytest.approx([1.0, 1.0], abs=0.2)  # the cause moves z most


def test_a_floor_is_no_other_if_nothing_was_explained(coloured):
    assert renew_floor(coloured, coloured.problem.like, np.random.default_rng(0)) is None

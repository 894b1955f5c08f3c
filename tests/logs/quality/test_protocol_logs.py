"""Nothing is refused or falsely flagged in what `ffgym record` makes: slow, at rest, swinging, with noisy torques."""

from functools import cache

import numpy as np
import pytest

from ffgym.effects import EFFECTS
from ffgym.envs.machines import make_rig
from ffgym.logs.quality import check_quality
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Resolver, SimulatedRig, TorqueSensor
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import PROTOCOLS, plan_session, record
from ffgym.simulation.protocols.one_by_one import SlowTriangles, SpeedLadder, Table61
from ffgym.simulation.protocols.rests import Holds

ROBOT = "irb4600_60_205"
NOISE = 0.005
"""Of the measured torque, in peak torques: `--torque-noise-percent 0.5`."""

QUICK = (
    SpeedLadder(joints=("j2",), speeds=(0.05, 3.0), longest=1.0),
    Table61(joints=("j2",), records=(1, 15), least=1.0, periods=2),
    SlowTriangles(joints=("j2",), sizes=(2.0,), period=1.0, periods=2),
)
"""One joint that carries load, slow and fast; the others rest."""


@cache
def arm() -> RigidArm:
    return RigidArm(load_robot(ROBOT))


def logs(protocol, *, noise: float) -> list[Recording]:
    sensors = (Resolver(bits=16), TorqueSensor(noise=noise * arm().robot.drive.peak_torque))
    return list(record(plan_session(arm(), [protocol]), SimulatedRig(arm=arm(), sensors=sensors), record_dt=1e-3))


def objections(recording: Recording) -> list[str]:
    return [f.message for f in check_quality(recording, arm().robot, ("position", "torque")).problems]


@pytest.mark.parametrize("noise", [0.0, NOISE])
@pytest.mark.parametrize("protocol", QUICK, ids=lambda protocol: protocol.name)
def test_nothing_is_said_against_logs_of_one_joint_while_others_rest(protocol, noise):
    for recording in logs(protocol, noise=noise):
        assert objections(recording) == [], recording.header.segment


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, NOISE])
@pytest.mark.parametrize("name", [name for name in PROTOCOLS if name != "circles"])
def test_nothing_is_said_against_logs_of_any_protocol(name, noise):
    one = {"joints": ("j2",)} if name in ("speed_ladder", "table_6_1", "slow_triangles") else {}
    for recording in logs(PROTOCOLS[name](**one), noise=noise):
        assert objections(recording) == [], recording.header.segment


@pytest.mark.slow
def test_nothing_is_said_against_slow_and_fast_sines_of_a_workcell():
    """Friction that turns round over more than the description's distance is not late, nor a swinging arm wrong."""
    rig = make_rig("workcell:thesis")
    protocol = Table61(joints=("j2",), records=(1, 15), least=1.0, periods=2)
    for recording in record(plan_session(arm(), [protocol]), rig, record_dt=1e-3):
        assert objections(recording) == [], recording.header.segment


def test_a_torque_that_is_late_is_seen_in_a_fast_sine():
    (recording,) = logs(Table61(joints=("j2",), records=(12,), least=2.0), noise=0.0)
    late = {f"motor.effort.{j}": np.roll(recording[f"motor.effort.{j}"], 60) for j in recording.header.joints}
    alone = {name: values for name, values in recording.columns.items() if "effort" not in name}
    found = check_quality(Recording(alone | late, recording.header), arm().robot).problems
    assert {finding.check for finding in found} == {"torque_lag"}


def of_an_ill_joint(protocol, effect) -> list[Recording]:
    machine = Machine(robot=arm().robot, effects=(effect,))
    rig = SimulatedRig(
        arm=arm(), machine=machine, sensors=(Resolver(bits=16), TorqueSensor(noise=0.03 * arm().robot.friction.coulomb))
    )
    return list(record(plan_session(arm(), [protocol]), rig, record_dt=2e-3))


def test_a_torque_that_repeats_with_the_turn_of_the_only_joint_that_moves_is_not_late():
    """It makes some other delay explain more by half of the energy; delays make more of a difference."""
    cogging = EFFECTS["cogging"].on(arm().robot, "j2", amplitude=0.3, cycles=15.0, phase=4.27)
    for recording in of_an_ill_joint(Holds(joints=("j2",), poses=4, rest=1.0), cogging):
        (finding,) = check_quality(recording, arm().robot).of("torque_lag")
        assert finding.verdict == "ok", recording.header.segment


def standing_while_set_points_go_on(jump: float) -> Recording:
    """A joint that turns round slowly, stands for 40 ms, and goes on from there, or from where it is by then."""
    recording = logs(SlowTriangles(joints=("j2",), sizes=(8.0,), period=1.0, periods=2), noise=0.0)[0]
    name = "motor.position.j2"
    angle = recording[name].copy()
    row = int(np.flatnonzero(recording["reference.position.j2"] == recording["reference.position.j2"].max())[0]) + 300
    missed = angle[row + 40] - angle[row]
    angle[row : row + 40] = angle[row]
    angle[row + 40 :] -= (1 - jump) * missed
    step = 2 * np.pi / 2**16
    return recording.with_columns({name: np.round(angle / step) * step})


@pytest.mark.parametrize(("jump", "verdict"), [(0.0, "ok"), (1.0, "flagged")])
def test_a_joint_that_sticks_goes_on_from_where_it_stood_and_a_column_that_is_stuck_jumps(jump, verdict):
    (finding,) = check_quality(standing_while_set_points_go_on(jump), arm().robot).of("stuck")
    assert finding.verdict == verdict, finding.message


@cache
def logs_of_one_axis() -> tuple[Recording, ...]:
    """Whose friction turns round over fifty times the angle of the joints of a robot: it has no gearbox."""
    bare = RigidArm(load_robot("one_axis"))
    rig = SimulatedRig(arm=bare, sensors=(Resolver(bits=16), TorqueSensor(noise=0.03 * bare.robot.friction.coulomb)))
    return tuple(record(plan_session(bare, [PROTOCOLS["diagnosis"]()]), rig, record_dt=1e-3))


def lag_of(recording: Recording, late: float = 0.0):
    """What is said of the delay of its torque, if that comes `late` [s]."""
    rows = round(late / recording.dt)
    names = [name for name in recording.columns if "effort" in name]
    columns = {
        name: np.r_[recording[name][:1].repeat(rows), recording[name][: len(recording) - rows]] for name in names
    }
    (finding,) = check_quality(recording.with_columns(columns), load_robot(recording.header.robot)).of("torque_lag")
    return finding


def test_friction_that_turns_round_slowly_is_no_late_torque():
    for recording in logs_of_one_axis():
        assert lag_of(recording).verdict == "ok", recording.header.segment


def test_torque_of_another_clock_is_refused_and_flagged_where_a_slow_motion_hides_how_late_it_is():
    verdicts = {recording.header.segment: lag_of(recording, late=0.11).verdict for recording in logs_of_one_axis()}
    assert verdicts.pop("diagnosis.slow_triangle") in ("flagged", "refused")
    assert set(verdicts.values()) == {"refused"}, verdicts

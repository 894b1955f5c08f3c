"""Causes that look alike are told apart by the motion that is proposed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.core.errors import FFGymError
from ffgym.diagnosis.separation import WARMING, design_separating_motion
from ffgym.diagnosis.sessions import propose_sessions
from ffgym.diagnosis.settings import settings
from ffgym.recordings import read_folder
from ffgym.robot import load_robot
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import load_protocols, plan_session, record
from tests.diagnosis.separation.rival_samples import SAMPLE_DT, arm_of, cause, log_ratio, noise_of, sensors_of

RIGID = (("stribeck_peak", "dwell_stiction"), ("torque_delay", "rotor_inertia"))
ELASTIC = (
    ("asymmetry", "torque_offset"),
    ("load_friction", "torque_constant"),
    ("temperature_friction", "viscous_level"),
    ("position_friction", "cogging"),
    ("cogging", "torque_ripple"),
    ("kinematic_error", "resolver_ripple"),
    ("torsional_hysteresis", "backlash"),
    ("presliding", "stribeck_peak"),
    ("joint_stiffness", "hardening"),
    ("coulomb_level", "torsional_hysteresis"),
)


@cache
def proposed(robot, joint, names, louder=1.0):
    """What is proposed for two causes on a joint, in so many times the usual noise."""
    causes = [cause(name, joint) for name in names]
    arm = arm_of(robot)
    noise = {channel: louder * rms for channel, rms in noise_of(arm.robot).items()}
    return causes, design_separating_motion(arm, Machine.of(arm.robot), causes, noise)


def recorded(arm, machine, protocols):
    motions = plan_session(arm, protocols)
    rig = SimulatedRig(arm=arm, machine=machine, sensors=sensors_of(arm.robot))
    return list(record(motions, rig, seed=1, record_dt=SAMPLE_DT))


def separates(robot, joint, names, tmp_path, *, both=True):
    """Whether a recording of the proposal says which cause a machine has: the first one, or whichever it is."""
    causes, motion = proposed(robot, joint, names)
    file = tmp_path / "next.toml"
    file.write_text(motion.toml)
    arm = arm_of(robot)
    nominal = replace(Machine.of(arm.robot), climate=WARMING)
    for right, wrong in (causes, causes[::-1]) if both else (causes,):
        recordings = recorded(arm, right.on(nominal), load_protocols(file))
        if log_ratio(recordings, nominal, right, wrong) < settings().rivals.log_ratio:
            return False
    return True


def test_the_proposed_motion_separates_causes(tmp_path):
    assert separates("one_axis", "j1", ("stribeck_peak", "dwell_stiction"), tmp_path, both=False)


@pytest.mark.slow
@pytest.mark.parametrize("names", RIGID, ids="-".join)
def test_the_proposed_motion_separates_causes_of_a_rigid_axis(names, tmp_path):
    assert separates("one_axis", "j1", names, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("names", ELASTIC, ids="-".join)
def test_the_proposed_motion_separates_causes_of_an_elastic_arm(names, tmp_path):
    assert separates("two_link", "shoulder", names, tmp_path)


@pytest.mark.slow
def test_warming_up_separates_what_temperature_does_from_what_it_does_not():
    _, motion = proposed("two_link", "shoulder", ("temperature_friction", "viscous_level"))
    assert motion.protocol == "warm_up"


def test_rests_separate_breakaway_that_grows_from_one_that_does_not(tmp_path, capsys):
    causes, motion = proposed("one_axis", "j1", ("stribeck_peak", "dwell_stiction"))
    assert motion.protocol == "rests"
    assert motion.between == tuple(one.label for one in causes)
    file = tmp_path / "next.toml"
    file.write_text(motion.toml)
    assert main(["record", "one_axis", str(file), "--out", str(tmp_path / "log")]) == 0
    assert len(read_folder(tmp_path / "log")) == len(plan_session(arm_of("one_axis"), load_protocols(file)))


@pytest.mark.slow
def test_nothing_is_proposed_for_causes_that_no_motion_tells_apart():
    arm = arm_of("one_axis")
    twins = [cause("coulomb_level", "j1"), cause("coulomb_level", "j1").move([0.01])]
    assert design_separating_motion(arm, Machine.of(arm.robot), twins, noise_of(arm.robot)) is None


def test_more_noise_makes_the_expectation_smaller():
    names = ("stribeck_peak", "dwell_stiction")
    quiet, loud = (proposed("one_axis", "j1", names, louder)[1] for louder in (1.0, 2.0))
    assert loud.expected < quiet.expected / 2


def test_one_cause_cannot_be_separated():
    arm = arm_of("one_axis")
    with pytest.raises(FFGymError, match="two causes"):
        design_separating_motion(arm, Machine.of(arm.robot), [cause("cogging", "j1")], noise_of(arm.robot))


@pytest.mark.parametrize("robot", ["one_axis", "two_link", "irb4600_60_205"])
def test_every_proposal_is_a_protocol_file_of_a_minute_or_so(robot, tmp_path):
    arm = arm_of(robot)
    for proposal in propose_sessions(arm.robot, arm.robot.joints[:1]):
        file = tmp_path / f"{proposal.name}.toml"
        file.write_text(proposal.toml())
        from_file, planned = (plan_session(arm, p) for p in (load_protocols(file), proposal.protocols()))
        assert [m.reference.name for m in from_file] == [m.reference.name for m in planned]
        assert all(np.array_equal(a.reference.q, b.reference.q) for a, b in zip(from_file, planned, strict=True))
        assert sum(motion.reference.duration for motion in planned) <= settings().rivals.longest_session


def test_proposals_for_a_robot_without_a_work_area_have_no_circles():
    assert "circles" not in {proposal.name for proposal in propose_sessions(load_robot("one_axis"), ["j1"])}

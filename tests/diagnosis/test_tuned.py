"""Models whose numbers are all wrong at once: fitted to recordings together."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.tuning import Breakaway, tune
from ffgym.effects import EFFECTS
from ffgym.robot import RigidArm
from ffgym.simulation import SimulatedRig, sensors_of
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import load_protocols, plan_session
from ffgym.simulation.protocols.sessions import record


@pytest.fixture(scope="module")
def described(one_axis):
    """The one-axis model as somebody wrote it down who measured nothing."""
    friction, drive = one_axis.friction, one_axis.drive
    rise = 0.6 * (friction.static - friction.coulomb)
    return replace(
        one_axis,
        friction=replace(
            friction.scale(viscous=1.5, bristle_stiffness=0.7),
            coulomb=0.7 * friction.coulomb,
            static=0.7 * friction.coulomb + rise,
        ),
        drive=replace(drive, rotor_inertia=0.8 * drive.rotor_inertia),
    )


@pytest.fixture(scope="module")
def recordings(one_axis, described):
    """Of the one-axis model under a controller for what was written down."""
    rig = SimulatedRig(arm=RigidArm(described), machine=Machine(robot=one_axis), sensors=sensors_of(one_axis))
    motions = plan_session(rig.arm, load_protocols("diagnosis"))
    return list(record([motions[i] for i in (0, 1, 4)], rig, n_threads=1))


def ratios(found, truth):
    """Numbers of one robot over those of another."""
    friction = ("coulomb", "static", "viscous", "bristle_stiffness")
    numbers = [float(getattr(found.friction, name)[0] / getattr(truth.friction, name)[0]) for name in friction]
    return np.array([*numbers, float(found.drive.rotor_inertia[0] / truth.drive.rotor_inertia[0])])


def test_all_numbers_are_found_together(one_axis, described, recordings):
    found = tune(Machine(robot=described), recordings)
    assert np.all(np.abs(ratios(described, one_axis) - 1) > 0.1)
    *friction, rotor = ratios(found.robot, one_axis)
    assert friction == pytest.approx(np.ones(4), abs=0.05)
    assert 0.8 < rotor < 1.05  # of a swinging arm: torque hardly tells its rotor from its links


def test_effects_stay_as_they_are_and_numbers_are_those_beside_them(one_axis, described, recordings):
    offset = EFFECTS["torque_offset"].on(one_axis, offset=0.05)
    found = tune(Machine(robot=described, effects=(offset,)), recordings)
    assert found.effects == (offset,)
    assert ratios(found.robot, one_axis)[:4] == pytest.approx(np.ones(4), abs=0.05)


@pytest.mark.slow
def test_friction_is_found_on_both_sides_of_a_spring_and_stays_on_one(two_link):
    described, true = two_link.with_arm_share([0.6, 0.0]), two_link.with_arm_share([0.35, 0.0])
    rig = SimulatedRig(arm=RigidArm(described), machine=Machine(robot=true), sensors=sensors_of(true))
    (recording,) = record(plan_session(rig.arm, load_protocols("diagnosis"))[1:2], rig, n_threads=1)
    found = tune(Machine(robot=described), [recording.slice(0, 4000)])
    shared, kept = found.robot.arm_share
    assert shared == pytest.approx(0.35, abs=0.05)
    assert kept == 0
    assert found.robot.friction.coulomb == pytest.approx(true.friction.coulomb, rel=0.05)


def test_breakaway_torque_never_falls_below_the_coulomb_torque(one_axis):
    lowest = Breakaway(level=np.array([-0.95]), velocity=np.array([0.0])).in_description(one_axis)
    assert np.all(lowest.friction.static >= lowest.friction.coulomb)
    with pytest.raises(FFGymError, match=r"at least -0\.95"):
        Machine(robot=one_axis, effects=(Breakaway(level=np.array([-1.2]), velocity=np.array([0.0])),))

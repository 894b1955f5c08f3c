"""Several effects together: the rest that they come to, and the state that all of them are asked at."""

import ast
import inspect
import textwrap
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from ffgym.agents.elastic import elastic_law
from ffgym.agents.model import model_law
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import replay
from ffgym.effects import State
from ffgym.effects.effect import FrictionEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import number
from ffgym.effects.together import find_rest
from ffgym.paths import joint_reference, joint_sine, multisine
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Churning(FrictionEffect):
    """Drag of lubricant, a share of the torque that would stop the rotor in a second."""

    name = "churning"

    share: Array = parameter("share of the stopping torque", unit="1", low=0.0, high=10.0, source="made up")

    def friction(self, state):
        """Drag [N m], by variables that only this test knows."""
        return self.share * state.stopping_torque


@pytest.fixture
def wider(monkeypatch):
    """Two more variables of a state: a number of the description, and what follows from it."""
    stopping = cached_property(lambda state: state.rotor_inertia * state.motor_speed)
    for name, variable in (("rotor_inertia", number("drive.rotor_inertia")), ("stopping_torque", stopping)):
        variable.__set_name__(State, name)
        monkeypatch.setattr(State, name, variable, raising=False)
    State.names.cache_clear()
    yield
    State.names.cache_clear()


def test_a_new_variable_of_the_state_is_one_entry_for_plant_replay_and_feedforward(wider, arm, corners):
    robot = arm.robot
    nominal, machine = Machine(robot=robot), Machine(robot=robot, effects=(Churning.on(robot, share=10.0),))
    swing = multisine(corners["p1"], np.full((1, 6), 0.01), [2.0], np.zeros((1, 6)), 0.5, ramp=0.15, dwell=0.05)
    reference = joint_reference(robot, swing)
    runs = [Run(reference=reference, law=law) for law in (elastic_law(arm), model_law(machine, arm))]
    plain, knowing = simulate(runs, machine=machine, n_threads=1)
    # feed-forward gives what the effect takes
    drag = 10.0 * robot.drive.rotor_inertia * plain.joint_array("motor.velocity")
    more = knowing.joint_array("compensation.effort") - plain.joint_array("compensation.effort")
    np.testing.assert_allclose(more, drag, atol=0.1 * np.abs(drag).max())
    # the motors of the plant took it, and a replay says so
    log = assemble_log(robot, [plain])
    without, with_it = (
        rms(replay(log, one).torque[:, 0] - plain.joint_array("motor.effort")) for one in (nominal, machine)
    )
    assert with_it < 0.3 * without


@pytest.mark.parametrize("answer", [None, np.zeros((1, 1)), (np.zeros((1, 1)), np.zeros((1, 1, 0)))])
def test_an_effect_that_does_not_return_torques_and_memory_is_named(one_axis, monkeypatch, answer):
    monkeypatch.setattr(Churning, "torques", lambda self, state, memory, dt: answer)
    run = Run(reference=joint_reference(one_axis, joint_sine([0.5], 1.0, 0.1)))
    with pytest.raises(FFGymError, match="torques of effect 'churning' must return Torques and the memory, got "):
        simulate([run], machine=Machine(robot=one_axis, effects=(Churning.on(one_axis, share=1.0),)), n_threads=1)


def test_variables_of_a_state_follow_from_those_above_them_alone():
    names = State.names()
    for k, name in enumerate(names):
        if isinstance(formula := vars(State)[name], cached_property):
            nodes = ast.walk(ast.parse(textwrap.dedent(inspect.getsource(formula.func))))
            used = {
                node.attr for node in nodes if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "self"
            }
            assert used <= {*names[:k], "drive"}, name


def test_a_changed_variable_changes_what_follows_from_it_and_not_what_was_given(two_link):
    zero = np.zeros(2)
    state = State.of(two_link, deflection=zero, deflection_rate=zero, joint_angle=zero, motor_torque=zero + 3.0)
    assert not state.load_at_motor.any()
    assert state.link_angle[0] == 0.0
    bent = state.with_values(deflection=zero + 1e-3)
    np.testing.assert_allclose(bent.load, -1e-3 * two_link.drive.joint_stiffness)
    np.testing.assert_allclose(bent.load_at_motor, two_link.drive.motor_torque(bent.load))
    np.testing.assert_array_equal(bent.link_angle, bent.deflection)
    assert bent.motor_torque[0] == 3.0
    wound = bent.with_values(wound=zero + 2.0)
    np.testing.assert_allclose(wound.load, bent.load + 2.0)


def test_a_variable_that_nothing_tells_is_named(two_link):
    state = State.of(two_link, joint_angle=np.zeros(2))
    with pytest.raises(AttributeError, match="made without motor_torque"):
        _ = state.motor_torque


@pytest.mark.parametrize("stiffness", [1e3, 1e9])
def test_the_rest_balances_a_spring_that_hardens(stiffness):
    cubic, load_at_rest = 1e15, np.array([[120.0, -5.0]])
    rest = find_rest(lambda x: stiffness * x + cubic * x**3 - load_at_rest, np.zeros((1, 2)))
    np.testing.assert_allclose(stiffness * rest + cubic * rest**3, load_at_rest, rtol=1e-9)


@pytest.mark.parametrize("near", [-2e-3, 0.0, 5e-4, 1e-2])
def test_without_load_the_rest_is_within_the_gap(near):
    gap, off = 3e-4, 1e-4

    def pull(x):
        return 1e5 * np.where(np.abs(x - off) > gap, x - off - gap * np.sign(x - off), 0.0)

    rest = find_rest(pull, np.full((1, 1), near))
    assert abs(float(rest[0, 0]) - off) <= gap
    assert find_rest(pull, np.full((1, 1), off)) == pytest.approx(off)

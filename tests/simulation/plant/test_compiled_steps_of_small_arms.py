"""Compiled steps of an arm of two links: the numbers of numpy to rounding, whatever runs beside and before."""

import ctypes
import re
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest

from ffgym.effects import EFFECTS, TorqueEffect, Torques, parameter
from ffgym.robot import load_robot
from ffgym.simulation.plant import Climate, Machine, Plant
from ffgym.simulation.plant.compiled import engine_hook, functions
from ffgym.simulation.plant.compiled.code import compile_code
from ffgym.simulation.plant.compiled.formulas import can_trace, trace_step, untraceable_kinds
from ffgym.simulation.plant.compiled.tracing import Untraceable
from tests.simulation.plant.driving import controls

DT = 0.00025
STEPS = 24


@dataclass(frozen=True, kw_only=True, eq=False)
class Swaying(TorqueEffect):
    """Acts at all three places, by the time, the climate and the motor's torque, and remembers two speeds."""

    name = "swaying"
    title = equation = signature = way_in = "a test"
    side = "link"
    size: np.ndarray = parameter("a", unit="N m", low=0.0, high=1.0, source="a test")  # noqa: RUF009

    def initial_memory(self, state):
        return np.stack([state.motor_speed, 0.0 * state.motor_speed], axis=-1)

    def torques(self, state, memory, dt):
        older, old = memory[..., 1], memory[..., 0]
        motor = self.size * np.sin(40.0 * state.time + state.temperature + old - older / dt * 1e-3)
        spring = 2.0 * self.size * np.tanh(state.loop_torque + state.bristle)
        link = -3.0 * self.size * np.tanh(0.1 * state.load + state.link_angle)
        return Torques(motor=motor, spring=spring, link=link), np.stack([state.motor_speed, old], axis=-1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Branching(TorqueEffect):
    """An effect of which no code can be made."""

    name = "branching"
    title = equation = signature = way_in = "a test"
    side = "motor"
    size: np.ndarray = parameter("a", unit="N m", low=0.0, high=1.0, source="a test")  # noqa: RUF009

    def torques(self, state, memory, dt):
        return Torques(motor=-self.size * np.tanh(state.motor_speed)) if np.all(state.time >= 0) else Torques(), memory


@dataclass(frozen=True, kw_only=True, eq=False)
class Forgetful(TorqueEffect):
    """An effect that remembers less than it began with."""

    name = "forgetful"
    title = equation = signature = way_in = "a test"
    side = "motor"
    size: np.ndarray = parameter("a", unit="N m", low=0.0, high=1.0, source="a test")  # noqa: RUF009

    def initial_memory(self, state):
        return np.stack([state.motor_speed, state.motor_speed], axis=-1)

    def torques(self, state, memory, dt):
        return Torques(motor=-self.size * np.tanh(memory[..., 0])), memory[..., :1]


def arm(*, rigid=(False, False), lag=(0.0, 0.0), period=0.0, share=None):
    """A rigid or elastic arm whose drives have a torque loop or read resolvers, with friction in its bearings."""
    robot = load_robot("two_link")
    robot = replace(robot, friction=replace(robot.friction, arm_share=share))
    stiffness = np.where(rigid, np.inf, robot.drive.joint_stiffness)
    drive = replace(robot.drive, joint_stiffness=stiffness, torque_lag=np.array(lag), resolver_period=period)
    return replace(robot, drive=drive, sensors=replace(robot.sensors, encoder_bits=12))


def loaded(robot, *more, size=0.5):
    """A machine with effects that remember, read, and act on links."""
    climate = Climate(ambient=15.0, rise=np.array([20.0]), time_constant=900.0, running_since=60.0)
    return Machine(robot=robot, effects=(Swaying.on(robot, size=size), *more), climate=climate)


def ripple(robot, amplitude=1e-3):
    return EFFECTS["resolver_ripple"].on(robot, amplitude=amplitude, cycles=2.0, phase=0.3)


def late(robot):
    return EFFECTS["torque_delay"].on(robot, delay=2.6 * DT, lag=1e-3)


def plant_of(machines, by_numpy=False):
    """Plant of machines at rest at home; without code if `by_numpy`."""
    plant = Plant(Machine.of(machines[0]), len(machines), n_threads=1)
    plant.become(range(len(machines)), machines)
    plant.rest(np.tile(plant.robot.work_area.home, (len(machines), 1)))
    if by_numpy:
        vars(plant._forces)["_compiled"] = (None, np.ones(len(machines), dtype=np.bool_))
    return plant


def swing(plant, ids=None, seed=0):
    """Drive simulations off in two pieces, each its own way; returns qpos, qvel, act and readings (B', S, .)."""
    rows = range(plant.n_robots) if ids is None else ids
    wanted = []
    for row in rows:
        rng = np.random.default_rng([seed, row])
        home = plant.robot.drive.motor_angle(plant.robot.work_area.home)
        away = np.cumsum(rng.uniform(0.0, 0.05, (STEPS, 2)), axis=0)
        wanted.append(controls(plant, position=home + away, velocity=rng.normal(size=(STEPS, 2)), torque=away))
    ids = None if ids is None else np.array(ids)
    parts = [plant.advance_with_readings(part, ids) for part in np.split(np.stack(wanted), 2, axis=1)]
    return [None if each[0] is None else np.concatenate(each, axis=1) for each in zip(*parts, strict=True)]


def assert_same(found, expected, tolerance=1e-12):
    for one, other in zip(found, expected, strict=True):
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * np.abs(other).max())


def is_compiled(plant):
    compiled, by_numpy = plant._forces._compiled
    return compiled is not None and not by_numpy.any()


def reading_arms():
    """Arms with torque loops and rigid joints that read resolvers at each step, at each second one, and not at all."""
    made = [arm(rigid=(True, False), lag=(2e-3, 1e-3), period=period) for period in (DT, 2 * DT, 0.0)]
    return [
        loaded(made[0], ripple(made[0]), late(made[0])),
        loaded(made[1], size=0.2),
        loaded(made[2], ripple(made[2], 2e-3)),
    ]


SORTS = {
    "elastic": lambda: [loaded(arm()), Machine(robot=arm()), loaded(arm(), late(arm()), size=0.1)],
    "rigid": lambda: [loaded(arm(rigid=(True, True)))] * 2,
    "one rigid": lambda: [loaded(arm(rigid=(True, False)), size=size) for size in (0.5, 0.1)],
    "reading": reading_arms,
    "rippling": lambda: [loaded(arm(), ripple(arm())), loaded(arm())],
    "in the bearings": lambda: [loaded(arm(lag=(2e-3, 1e-3), share=np.array([0.3, 0.6])))],
    "resolvers alone": lambda: [Machine(robot=arm(period=2 * DT)), Machine(robot=arm(period=3 * DT))],
}


@pytest.mark.parametrize("sort", SORTS)
def test_code_gives_what_numpy_gives(sort):
    machines = SORTS[sort]()
    compiled, by_numpy = plant_of(machines), plant_of(machines, by_numpy=True)
    assert is_compiled(compiled)
    for seed in (0, 1):
        assert_same(swing(compiled, seed=seed), swing(by_numpy, seed=seed))
    for one, other in zip(compiled._forces.copy_memories(), by_numpy._forces.copy_memories(), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-11 * np.abs(other).max(initial=1.0))


def test_effects_move_the_arm_differently():
    """Else two ways of computing nothing would be the same."""
    plain, with_effects = plant_of([Machine(robot=arm())]), plant_of([loaded(arm())])
    difference = np.abs(swing(with_effects)[0] - swing(plain)[0])
    assert difference.max() > 1e-6


@pytest.mark.parametrize("ids", [[2], [0, 2], [1, 2]])
def test_some_go_on_as_they_would_among_all(ids):
    machines = reading_arms()
    some, every = plant_of(machines), plant_of(machines)
    others = np.setdiff1d(np.arange(3), ids)
    still = some.batch.state[others].copy()
    for seed in (0, 1):
        found, expected = swing(some, ids, seed), swing(every, seed=seed)
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_array_equal(one, other[ids])
    np.testing.assert_array_equal(some.batch.state[others], still)


def test_recorded_readings_are_those_that_servos_know_when_the_step_has_ended():
    plant = plant_of(reading_arms())
    recorded = swing(plant)[3]
    np.testing.assert_array_equal(recorded[:, -1], plant.reading())
    assert np.ptp(recorded, axis=1).min() > 0


def test_what_is_not_asked_for_is_computed_all_the_same():
    kept, driven = plant_of(reading_arms()), plant_of(reading_arms())
    rows = np.full((3, 7, 6), 3.0)
    kept.advance_with_readings(rows)
    driven.drive(rows)
    np.testing.assert_array_equal(kept.batch.state, driven.batch.state)
    np.testing.assert_array_equal(kept.reading(), driven.reading())


def test_machines_with_and_without_code_run_side_by_side():
    robot = arm(rigid=(True, False), period=2 * DT)
    machines = [loaded(robot), loaded(robot, Branching.on(robot, size=0.5)), loaded(robot, size=0.2)]
    plant = plant_of(machines)
    compiled, by_numpy = plant._forces._compiled
    assert compiled is not None
    assert by_numpy.tolist() == [False, True, False]
    found, expected = swing(plant), swing(plant_of(machines, by_numpy=True))
    assert_same(found, expected)
    np.testing.assert_array_equal(found[0][1], expected[0][1])
    some = swing(plant_of(machines), [1, 2])
    for one, other in zip(some, found, strict=True):
        np.testing.assert_array_equal(one, other[[1, 2]])
    # all that run have no code
    alone = swing(plant_of(machines), [1])
    np.testing.assert_array_equal(alone[0], found[0][[1]])


@pytest.mark.parametrize("kind", [Branching, Forgetful])
def test_kinds_without_code_are_told_from_the_others(kind):
    robot = arm()
    plant = plant_of([loaded(robot, kind.on(robot, size=0.5), ripple(robot))])
    layout = plant._forces._layout()
    assert untraceable_kinds(layout) == {kind}
    assert not can_trace(layout)
    assert can_trace(replace(layout, kinds=tuple(each for each in layout.kinds if each[0] is not kind)))


def test_code_is_of_memories_that_keep_their_shape():
    robot = arm()
    layout = plant_of([loaded(robot, Forgetful.on(robot, size=0.5))])._forces._layout()
    with pytest.raises(Untraceable, match="a memory of another shape"):
        trace_step(layout)


def test_a_layout_knows_what_is_remembered_and_what_servos_know():
    plant = plant_of(reading_arms())
    layout = plant._forces._layout()
    assert layout.n_joints == 2
    sizes = [size for _, size in layout.kinds]
    assert layout.memories == [*enumerate(sizes), ("motor", 1), ("angle", 1), ("speed", 1), ("count", 1)]
    assert layout.looks
    bare = replace(layout, reads=False, resolver_kinds=())
    assert not bare.looks
    assert replace(bare, reads=True).looks
    assert replace(layout, reads=False).looks
    assert replace(layout, reads=False).memories == [*enumerate(sizes), ("motor", 1)]


def test_layouts_of_one_structure_are_equal_whatever_their_numbers():
    one, other = (plant_of([loaded(arm(), size=size)])._forces._layout() for size in (0.5, 0.1))
    assert one == other
    assert hash(one) == hash(other)
    for another in (arm(rigid=(True, False)), arm(lag=(1e-3, 0.0)), arm(period=DT)):
        assert plant_of([loaded(another)])._forces._layout() != one


def test_without_readings_nothing_is_written_after_a_step():
    _, before, after = trace_step(plant_of([loaded(arm())])._forces._layout())
    assert before
    assert after == ([], [])


@pytest.fixture
def written(monkeypatch):
    """Code of arms that read resolvers, as the compiler is given it."""
    layout, texts = plant_of(reading_arms())._forces._layout(), []
    monkeypatch.setattr(functions, "compile_code", lambda text: texts.append(text) or compile_code(text))
    functions.compile_layout.__wrapped__(layout)
    return texts[0]


def test_readings_that_nobody_asked_for_have_room_for_all_joints(written):
    rooms = re.findall(r"%unread = alloca \[(\d+) x double\]", written)
    assert rooms == ["4", "4"]  # within a rollout and at its end: angles and speeds of two joints


def test_functions_of_a_step_are_called_with_what_they_take(written):
    """The compiler does not compare them."""
    takes, given = (
        {(name, len(arguments.split(","))) for name, arguments in re.findall(rf"{word} \w+ @(\w+)\((.*)\)", written)}
        for word in ("define", "call")
    )
    own = {"apply", "look", "known_at"}
    assert {each for each in given if each[0] in own} == {each for each in takes if each[0] in own}


@pytest.mark.parametrize("sort", ["reading", "rippling"])
def test_a_step_writes_where_quantities_of_each_joint_stand_in_the_engine(sort):
    layout = plant_of(SORTS[sort]())._forces._layout()
    graph, before, _ = trace_step(layout)
    written = {source[1]: [] for source, _ in before}
    for (_, name, places), _ in before:
        written[name].append(places)
    assert written["ctrl"] == [(0, 3), (1, 4)]  # angle and speed; the third of each joint is its torque
    motors, behind = layout.at.motor_qpos.tolist(), layout.at.deflection_of_joint.tolist()
    assert written["qfrc_applied"] == [tuple(motors), tuple(behind)]
    read = [node.value for node in graph.nodes.values() if node.operation == "given" and node.value[0] == "engine"]
    assert all(len(places) == 2 for _, _, places in read)


def test_marks_and_the_callback_are_there_while_rows_run_and_gone_after():
    plant = plant_of([loaded(arm())] * 3)
    compiled, _ = plant._forces._compiled
    marks = plant.batch.bind("xfrc_applied")
    assert engine_hook.is_free()
    with compiled._marks.set(np.array([0, 2])):
        assert (marks[:, 0, 0] != 0).tolist() == [True, False, True]
        assert marks[[0, 2], 0, 2].tolist() == [0.0, 2.0]
        assert engine_hook.is_free()
        with compiled._marks.set(np.array([1])):
            assert mujoco.get_mjcb_control() is not None
        assert mujoco.get_mjcb_control() is not None  # others still run
        assert not marks[1].any()
    assert mujoco.get_mjcb_control() is None
    assert not marks.any()
    assert engine_hook._users == 0


def test_a_callback_that_someone_else_sets_while_rows_run_stays_when_they_have_ended():
    compiled, _ = plant_of([loaded(arm())])._forces._compiled
    kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
    theirs = kind(lambda model, data: None)
    try:
        with compiled._marks.set(slice(None)):
            mujoco.set_mjcb_control(theirs)
        assert mujoco.get_mjcb_control() is theirs
        assert not engine_hook.is_free()
    finally:
        mujoco.set_mjcb_control(None)


def test_steps_are_counted_anew_in_each_rollout():
    plant = plant_of([loaded(arm())] * 3)
    for steps in (5, 3):
        plant.drive(np.zeros((2, steps, 6)), np.array([0, 2]))
        assert plant._forces._compiled[0]._steps.tolist() == [steps, 0, steps]


def test_where_nothing_is_compiled_the_callback_stays_someone_elses():
    plant, calls = plant_of([loaded(arm())]), []
    kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
    theirs = kind(lambda model, data: calls.append(1))
    mujoco.set_mjcb_control(theirs)
    try:
        assert not engine_hook.is_free()
        plant.drive(np.zeros((1, 4, 6)))
    finally:
        mujoco.set_mjcb_control(None)
    assert len(calls) == 4

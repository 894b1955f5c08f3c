"""Effects as compiled code: the same numbers as by numpy, whatever the batch, and numpy where there is no code."""

import ctypes
import threading
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS, ResolverEffect, TorqueEffect, Torques, parameter
from ffgym.robot import load_robot
from ffgym.simulation.plant import Climate, Machine, Plant
from ffgym.simulation.plant.compiled import engine_hook, functions
from ffgym.workcell import draw, workcell
from ffgym.workcell.equations import EQUATIONS
from tests.simulation.plant.driving import controls

KINDS = {
    name: kind
    for name, kind in {**EFFECTS, **EQUATIONS}.items()
    if issubclass(kind, TorqueEffect | ResolverEffect) and name != "wrist_coupling"
}
COLD = Climate(ambient=15.0, rise=np.array([20.0]), time_constant=900.0)


@pytest.fixture(scope="module")
def robot():
    return load_robot("irb4600_60_205")


def drawn(kind, robot, seed):
    """The effect with random parameters within their plausible ranges."""
    rng = np.random.default_rng(seed)
    known = kind.parameters().items()
    return kind(**{name: rng.uniform(p.low, p.high, p.shape(robot.n_joints)) for name, p in known})


def swing(plant, steps=320, pieces=2, ids=None):
    """Let all joints swing about home, with random torques beside; returns qpos, qvel, act and readings, (B, T, .)."""
    robot, rng = plant.robot, np.random.default_rng(1)
    t = plant.physics_dt * np.arange(steps)[:, None]
    home = robot.work_area.home
    q, dq = home + 0.01 * (1 - np.cos(60 * t)), np.broadcast_to(0.6 * np.sin(60 * t), (steps, len(home)))
    rows = controls(
        plant,
        position=robot.drive.motor_angle(q),
        velocity=robot.drive.motor_angle(dq),
        torque=0.1 * rng.normal(size=(steps, len(home))),
    )
    n = plant.n_robots if ids is None else len(ids)
    parts = [
        plant.advance_with_readings(np.broadcast_to(part, (n, *part.shape)), ids) for part in np.split(rows, pieces)
    ]
    return [np.concatenate(each, axis=1) if each[0] is not None else None for each in zip(*parts, strict=True)]


def plant_of(machines, n_threads=1, by_numpy=False):
    """Plant of machines at rest at home; without code if `by_numpy`."""
    plant = Plant(Machine.of(machines[0]), len(machines), n_threads=n_threads)
    plant.become(range(len(machines)), machines)
    plant.rest(np.tile(plant.robot.work_area.home, (len(machines), 1)))
    if by_numpy:
        vars(plant._forces)["_compiled"] = (None, np.ones(len(machines), dtype=np.bool_))
    return plant


def is_compiled(plant):
    compiled, by_numpy = plant._forces._compiled
    return compiled is not None and not by_numpy.any()


def assert_same(machines, rtol=1e-12):
    compiled, numpy = plant_of(machines), plant_of(machines, by_numpy=True)
    assert is_compiled(compiled)
    for one, other in zip(swing(compiled), swing(numpy), strict=True):
        if one is not None:
            np.testing.assert_allclose(one, other, rtol=0, atol=rtol * np.abs(other).max())
    assert np.all(compiled._forces._compiled[0]._steps == 160)  # the code was called, at every physics step
    for one, other in zip(compiled._forces._memories, numpy._forces._memories, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=10 * rtol * np.abs(other).max(initial=1.0))


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS.keys())
def test_each_effect_has_code_that_gives_what_numpy_gives(kind, robot):
    one, other = (Machine(robot=robot, effects=(drawn(kind, robot, seed),), climate=COLD) for seed in (0, 1))
    assert_same([one, Machine(robot=robot), other])


def test_effects_together_give_what_numpy_gives(robot):
    kinds = [kind for name, kind in KINDS.items() if name != "backlash"]  # in which rest takes long to find
    every = [tuple(drawn(kind, robot, seed) for kind in kinds[seed::3]) for seed in range(3)]
    assert_same([Machine(robot=robot, effects=effects, climate=COLD) for effects in every])


@pytest.mark.parametrize("name", ["thesis", "cold", "worn"])
def test_workcells_give_what_numpy_gives(name):
    assert_same([workcell(name).machine] * 2)


def test_drives_that_delay_torque_and_read_resolvers_give_what_numpy_gives():
    real = load_robot("irb4600_60_205_servo_drives")
    exact = replace(real, drive=replace(real.drive, resolver_period=0.0))
    ripple = drawn(EFFECTS["resolver_ripple"], real, 0)
    assert_same([Machine(robot=real), Machine(robot=exact), Machine(robot=real, effects=(ripple,))])


def test_rigid_joints_give_what_numpy_gives(robot):
    rigid = np.where(np.arange(6) % 2, np.inf, robot.drive.joint_stiffness)
    stiff = replace(robot, drive=replace(robot.drive, joint_stiffness=rigid))
    effects = tuple(
        EFFECTS[name].on(stiff, **v)
        for name, v in (
            ("load_friction", {"share": 0.05}),
            ("gravity_term", {"sine": 9.0, "cosine": 5.0, "stiffness": 3.0}),
        )
    )
    assert_same([Machine(robot=stiff, effects=effects), Machine(robot=stiff)])


def test_bits_do_not_depend_on_the_batch_its_order_or_the_number_of_threads(robot):
    machines = [draw(seed).machine for seed in (3, 12)]
    alone = [swing(plant_of([machine])) for machine in machines]
    for order, n_threads in (((0, 1, 0), 1), ((1, 0, 1), 3)):
        plant = plant_of([machines[k] for k in order], n_threads)
        together = swing(plant, pieces=4)
        for row, k in enumerate(order):
            for one, other in zip(together[:3], alone[k][:3], strict=True):
                np.testing.assert_array_equal(one[row], other[0])


def test_some_simulations_go_on_while_others_stand(robot):
    machines = [draw(seed).machine for seed in (3, 12, 4)]
    whole, part = plant_of(machines), plant_of(machines)
    before = part.batch.state[1].copy()
    found = swing(part, ids=np.array([0, 2]))[0]
    np.testing.assert_array_equal(before, part.batch.state[1])
    np.testing.assert_array_equal(found, swing(whole)[0][[0, 2]])


def test_going_back_repeats_every_bit():
    plant = plant_of([draw(12).machine, load_robot("irb4600_60_205")])
    swing(plant)
    saved = plant.save()
    first = swing(plant)
    plant.restore(saved)
    for one, other in zip(swing(plant)[:3], first[:3], strict=True):
        np.testing.assert_array_equal(one, other)


@dataclass(frozen=True, kw_only=True, eq=False)
class Picking(TorqueEffect):
    """An effect that looks numbers up, some of them side by side in its memory."""

    name = "picking"
    title = equation = signature = way_in = "a test"
    side = "motor"
    size: np.ndarray = parameter("a", unit="N m", low=0.0, high=0.1, source="a test")  # noqa: RUF009

    def initial_memory(self, state):
        return np.zeros((*state.motor_angle.shape, 4))

    def torques(self, state, memory, dt):
        index = np.trunc(np.abs(state.motor_angle)).astype(int)[..., None]
        known = np.stack([state.time + 0 * state.motor_angle, state.motor_speed, state.friction_sign], axis=-1)
        computed = np.take_along_axis(known, np.clip(index, 0, 2), axis=-1)[..., 0]
        remembered = np.take_along_axis(memory, np.clip(index, 0, 3), axis=-1)[..., 0]
        later = np.concatenate([np.tanh(state.motor_speed)[..., None], memory[..., :-1]], axis=-1)
        return Torques(motor=self.size * np.tanh(computed + remembered)), later


def test_an_effect_may_look_numbers_up(robot):
    assert_same([Machine(robot=robot, effects=(Picking.on(robot, size=0.1),))])


@dataclass(frozen=True, kw_only=True, eq=False)
class Odd(TorqueEffect):
    """An effect of which no code can be made."""

    title = equation = signature = way_in = "a test"
    side = "motor"
    drag: np.ndarray = parameter("a", unit="N m", low=0.0, high=0.1, source="a test")  # noqa: RUF009


@dataclass(frozen=True, kw_only=True, eq=False)
class Branching(Odd):
    name = "branching"

    def torques(self, state, memory, dt):
        if np.all(state.motor_speed == 0):
            return Torques(), memory
        return Torques(motor=-self.drag * np.tanh(state.motor_speed)), memory


@dataclass(frozen=True, kw_only=True, eq=False)
class Mixing(Odd):
    name = "mixing"

    def torques(self, state, memory, dt):
        return Torques(motor=-self.drag * np.tanh(np.roll(state.motor_speed, 1, axis=-1))), memory


@dataclass(frozen=True, kw_only=True, eq=False)
class OfOneJoint(Odd):
    name = "of_one_joint"

    def torques(self, state, memory, dt):
        return Torques(motor=-self.drag * np.tanh(state.motor_speed[..., :1])), memory


@dataclass(frozen=True, kw_only=True, eq=False)
class Noisy(Odd):
    name = "noisy"
    rng = np.random.default_rng(0)

    def torques(self, state, memory, dt):
        return Torques(motor=-self.drag * np.tanh(state.motor_speed + self.rng.normal())), memory


@dataclass(frozen=True, kw_only=True, eq=False)
class AddingTruths(Odd):
    name = "adding_truths"

    def torques(self, state, memory, dt):
        both = (state.motor_speed > 0) + (state.motor_speed > -1)
        return Torques(motor=-self.drag * both), memory


@pytest.mark.parametrize("kind", [Branching, Mixing, OfOneJoint, Noisy, AddingTruths])
def test_an_effect_without_code_is_computed_by_numpy_and_leaves_others_their_bits(kind, robot):
    odd, cell = Machine(robot=robot, effects=(kind.on(robot, drag=0.1),)), draw(12).machine
    mixed = plant_of([cell, odd])
    compiled, by_numpy = mixed._forces._compiled
    assert compiled is not None
    assert by_numpy.tolist() == [False, True]
    assert plant_of([odd])._forces._compiled[0] is None
    together, alone = swing(mixed, steps=64), swing(plant_of([cell]), steps=64)
    np.testing.assert_array_equal(together[0][0], alone[0][0])
    if kind is not Noisy:
        odd_alone = swing(plant_of([odd], by_numpy=True), steps=64)
        np.testing.assert_array_equal(together[0][1], odd_alone[0][0])


def test_code_of_others_does_not_depend_on_where_an_effect_without_code_stands(robot):
    cell, odd = draw(12).machine, Branching.on(robot, drag=0.1)
    before = Machine(robot=cell.robot, effects=(odd,), climate=cell.climate)
    together, alone = swing(plant_of([before, cell]), steps=64), swing(plant_of([cell]), steps=64)
    np.testing.assert_array_equal(together[0][1], alone[0][0])


def test_the_code_counts_the_steps_of_each_simulation(robot):
    plant = plant_of([Machine(robot=robot, effects=(Picking.on(robot, size=0.1),))] * 9)  # more than it has joints
    swing(plant, steps=8, ids=[1, 8])
    compiled, _ = plant._forces._compiled
    steps = compiled._steps
    assert steps.shape == (9,)
    assert steps[[1, 8]].min() > 0


def test_without_a_compiler_numpy_computes(robot, monkeypatch):
    monkeypatch.setattr("ffgym.simulation.plant.forces.can_compile", lambda: False)
    plant = plant_of([draw(12).machine])
    assert plant._forces._compiled[0] is None
    assert np.isfinite(swing(plant)[0]).all()


def test_the_callback_of_someone_else_is_left_alone(robot):
    calls = []
    kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
    theirs = kind(lambda model, data: calls.append(1))
    plant = plant_of([draw(12).machine])
    expected = swing(plant_of([draw(12).machine], by_numpy=True))[0]
    mujoco.set_mjcb_control(theirs)
    try:
        found = swing(plant)[0]
        assert mujoco.get_mjcb_control() is theirs
    finally:
        mujoco.set_mjcb_control(None)
    assert len(calls) == found.shape[1]
    np.testing.assert_array_equal(found, expected)


def test_no_callback_or_mark_is_left_behind(robot):
    plant = plant_of([draw(12).machine] * 2)
    swing(plant)
    assert mujoco.get_mjcb_control() is None
    assert not plant.batch.bind("xfrc_applied").any()


def test_the_engine_does_not_read_forces_on_the_body_of_the_world(robot):
    plain, marked = Plant(robot, 2, n_threads=1), Plant(robot, 2, n_threads=1)
    for plant in (plain, marked):
        plant.rest(np.tile(robot.work_area.home, (2, 1)))
    marked.batch.bind("xfrc_applied")[:, 0] = 123.0
    for one, other in zip(swing(marked)[:3], swing(plain)[:3], strict=True):
        np.testing.assert_array_equal(one, other)


def test_plants_of_several_threads_do_not_disturb_each_other():
    machines = [draw(3).machine, load_robot("irb4600_60_205_servo_drives"), load_robot("irb4600_60_205")]
    expected = [swing(plant_of([machine]), steps=1600)[0] for machine in machines]
    plants, found = [plant_of([machine]) for machine in machines], {}

    def run(k):
        found[k] = swing(plants[k], steps=1600, pieces=50)[0]

    threads = [threading.Thread(target=run, args=(k,)) for k in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in range(3):
        np.testing.assert_array_equal(found[k], expected[k])


def test_addresses_of_the_engine_hold_for_any_model(robot):
    data = mujoco.MjData(Plant(robot, 1).model)
    data.time = 3.25
    for name, offset in engine_hook.data_offsets().items():
        word = ctypes.c_int64.from_address(data._address + offset)
        if name == "time":
            assert ctypes.c_double.from_buffer(word).value == 3.25
        else:
            assert word.value == getattr(data, name).ctypes.data


def test_machines_of_one_structure_share_their_code():
    plant_of([draw(3).machine])._forces._compiled  # noqa: B018  # compiles it, if no test before has
    made = functions.compile_layout.cache_info().misses
    plant = plant_of([workcell("thesis").machine])
    plant._forces._compiled  # noqa: B018
    other = plant_of([workcell("cold").machine] * 3)
    other._forces._compiled  # noqa: B018
    assert functions.compile_layout.cache_info().misses <= made + 1


def test_a_delay_beyond_what_is_remembered_is_refused_at_once(robot):
    delay = EFFECTS["torque_delay"].on(robot, delay=0.02, lag=0.0)
    with pytest.raises(FFGymError, match=r"80\.0 physics steps is too long"):
        Plant(Machine(robot=robot, effects=(delay,)), 1)

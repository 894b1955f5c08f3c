"""Model feed-forward: what a machine's effects take from the path, the law gives back, step by step as all at once."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.agents.catalogue import find_law_name, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.elastic import ElasticLaw, elastic_law
from ffgym.agents.model import ModelLaw, left_alone, model_law
from ffgym.agents.model_along import BLOCK
from ffgym.agents.model_springs import cut_to_root, find_rising_root
from ffgym.control import CausalLaw
from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS, NativeEffect, ResolverEffect, TorqueEffect
from ffgym.paths import joint_reference, multisine
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Climate, Machine, save_machine
from ffgym.studies import circle_references
from scripts.exam.equations import VARIANTS
from tests.contract.test_agents import check_batch, check_samples, check_side_by_side
from tests.effects.effect_samples import as_strong_as_plausible, without_effect
from tests.robot.robot_samples import unusual

WARM = Climate(ambient=20.0, rise=np.array([25.0]), running_since=3600.0)
WITH_MEMORY = ("torsional_hysteresis", "dwell_stiction", "torque_delay", "cable_pull")
WITHOUT = ("kinematic_error", "hardening", "load_friction", "cogging", "torque_ripple", "asymmetry", "resolver_ripple")
GAP = "backlash"
"""A motor cannot jump across it."""
COMPENSATED = [
    name
    for name, effect in EFFECTS.items()
    if issubclass(effect, NativeEffect | TorqueEffect | ResolverEffect) and name != GAP
]


@pytest.fixture(scope="module")
def swing(irb4600, corners):
    """All joints swing about a pose of the work area, from rest to rest."""
    path = multisine(corners["p1"], np.full((1, 6), 0.01), [2.0], np.zeros((1, 6)), 0.5, ramp=0.15, dwell=0.05)
    return joint_reference(irb4600, path)


@pytest.fixture(scope="module")
def circle(arm):
    return circle_references(arm, ["p2"], [0.1], [0.003])["p2", 0.1]


def machine_with(robot, *names, share=0.5):
    effects = tuple(as_strong_as_plausible(EFFECTS[name], robot, share) for name in names)
    return Machine(robot=robot, effects=effects, climate=WARM)


def link_misses(reference, machine, laws):
    """RMS of how far links are from the reference, beyond where they began [rad], worst joint, for each law."""
    runs = [Run(reference=reference, law=law) for law in laws]
    found = []
    for recording in simulate(runs, machine=machine, n_threads=1, record_dt=0.004):
        link = recording.joint_array("link.position")
        miss = link - link[0] - (reference.q - reference.q[0])
        found.append(np.sqrt(np.mean(miss**2, axis=0)).max())
    return found


# What it is worth


@pytest.mark.parametrize("name", COMPENSATED)
def test_it_gives_back_what_an_effect_takes(name, swing, arm):
    machine = machine_with(arm.robot, name)
    nominal, knowing = link_misses(swing, machine, [elastic_law(arm), model_law(machine, arm)])
    (floor,) = link_misses(swing, arm.robot, [elastic_law(arm)])
    lost = np.sqrt(max(nominal**2 - floor**2, 0.0))
    assert knowing < 1.5 * floor + 0.1 * lost


def test_it_gives_back_what_several_take_together(swing, arm):
    machine = machine_with(arm.robot, *WITH_MEMORY, *WITHOUT, "payload", "coulomb_level", "servo_gains", share=0.3)
    nominal, knowing = link_misses(swing, machine, [elastic_law(arm), model_law(machine, arm)])
    assert knowing < 0.05 * nominal


def test_drives_with_a_delay_and_a_lag_are_given_their_torque_in_time(arm, circle):
    lag, delay = np.full(6, 2e-4), np.full(6, 5e-4)
    real = replace(arm.robot, drive=replace(arm.robot.drive, torque_lag=lag, torque_delay=delay))
    nominal, knowing = link_misses(circle, real, [elastic_law(arm), model_law(Machine(robot=real), arm)])
    (floor,) = link_misses(circle, arm.robot, [elastic_law(arm)])
    assert nominal > 3 * floor
    assert knowing < 1.1 * floor


def test_a_gap_between_teeth_is_crossed_where_the_load_changes_its_sign(arm):
    reference = circle_references(arm, ["p2"], [0.04], [0.001])["p2", 0.04]
    machine = Machine(robot=arm.robot, effects=(EFFECTS[GAP].on(arm.robot, "j1", half_gap=1e-4),))
    nominal, knowing = link_misses(reference, machine, [elastic_law(arm), model_law(machine, arm)])
    assert knowing < 0.3 * nominal


# What it is


def test_where_other_numbers_say_it_all_it_is_elastic_feed_forward_of_them(arm, circle):
    machine = machine_with(arm.robot, "payload", "joint_stiffness", "viscous_level", "tool_frame")
    law = model_law(machine, arm)
    assert isinstance(law, ElasticLaw)
    np.testing.assert_array_equal(law.torque(circle), elastic_law(RigidArm(machine.physical), arm).torque(circle))


def test_without_effects_its_own_equations_are_those_of_elastic_feed_forward(arm, circle):
    elastic = elastic_law(arm)
    law = ModelLaw(machine=Machine(robot=arm.robot), elastic=elastic)
    np.testing.assert_allclose(law.torque(circle), elastic.torque(circle), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", [*WITH_MEMORY, *WITHOUT, GAP])
def test_effects_at_their_null_value_change_nothing(name, arm, circle):
    law = model_law(Machine(robot=arm.robot, effects=(without_effect(EFFECTS[name], arm.robot),)), arm)
    assert isinstance(law, ModelLaw)
    np.testing.assert_allclose(law.torque(circle), elastic_law(arm).torque(circle), rtol=0, atol=2e-4)


def test_two_waves_of_a_gear_error_are_one_error_of_that_shape(arm, circle):
    kind, robot = EFFECTS["kinematic_error"], arm.robot
    waves = (
        kind.on(robot, amplitude=3e-4, cycles=1.0, phase=0.6),
        kind.on(robot, amplitude=1.2e-4, cycles=2.0, phase=2.2),
    )
    both = VARIANTS["two_wave_gear_error"].on(robot, amplitude=3e-4, cycles=1.0, phase=0.6)
    laws = [model_law(Machine(robot=robot, effects=effects), arm) for effects in (waves, (both,))]
    np.testing.assert_allclose(laws[0].torque(circle), laws[1].torque(circle), rtol=0, atol=1e-9)


@pytest.mark.slow
def test_samples_and_batches_with_effects_are_the_same_law(arm, circle, swing):
    law = model_law(machine_with(arm.robot, *WITH_MEMORY, *WITHOUT), arm)
    check_samples(law, swing)
    check_batch(law, circle)
    check_side_by_side(law, [swing, circle])


@pytest.mark.parametrize("names", [("torsional_hysteresis", *WITHOUT), ("backlash", "resolver_ripple"), WITH_MEMORY])
def test_blocks_of_samples_have_the_bits_of_single_steps(names, arm, circle, swing):
    law = model_law(machine_with(arm.robot, *names), arm)
    assert len(swing.t) > 2 * BLOCK
    for reference, torque in zip((swing, circle), law.torques_along([swing, circle]), strict=True):
        assert torque.tobytes() == CausalLaw.torque(law, reference).tobytes()


@given(st.integers(0, 10**9), st.sampled_from([0.0, 1e-5, 1e-4]))
def test_a_guessed_root_has_the_bits_of_cutting(seed, kink):
    rng = np.random.default_rng(seed)
    root, slope, cubic = rng.normal(scale=5e-4, size=6), 10 ** rng.uniform(3, 7, size=6), rng.uniform(0, 1e12)

    def rising(x):
        away = x - root
        return slope * (away + np.clip(away, -kink, kink)) + cubic * away**3

    for middle in (np.zeros(6), root, np.full(6, 2e-3)):  # anywhere, on a border of cells, beyond
        found, cut = find_rising_root(rising, middle, 1e-3), cut_to_root(rising, middle, 1e-3)
        assert found.tobytes() == cut.tobytes()


def test_on_a_rigid_axis_effects_of_the_motor_are_compensated(one_axis):
    machine = Machine(robot=one_axis, effects=(EFFECTS["cogging"].on(one_axis, amplitude=0.1, cycles=2.0),))
    path = multisine(np.zeros(1), np.full((1, 1), 0.3), [1.0], np.zeros((1, 1)), 1.0, ramp=0.2, dwell=0.05)
    laws = [elastic_law(RigidArm(one_axis)), model_law(machine)]
    nominal, knowing = link_misses(joint_reference(one_axis, path), machine, laws)
    assert knowing < 0.2 * nominal


def test_coupled_drives_and_slides_are_compensated_too(irb4600):
    robot = unusual(irb4600)
    low, high = robot.kinematics.range.T
    path = multisine((low + high) / 2, np.full((1, 6), 0.01), [2.0], np.zeros((1, 6)), 0.5, ramp=0.15, dwell=0.05)
    machine = machine_with(robot, "torsional_hysteresis", "kinematic_error", "cogging", "load_friction")
    laws = [elastic_law(RigidArm(robot)), model_law(machine)]
    nominal, knowing = link_misses(joint_reference(robot, path), machine, laws)
    assert knowing < 0.1 * nominal


@pytest.fixture(scope="module")
def with_friction_on_the_arm(irb4600):
    return irb4600.with_arm_share([0.73, 0.73, 0.73, 0.0, 0.0, 0.0])


def test_without_effects_friction_on_the_arm_is_that_of_elastic_feed_forward(with_friction_on_the_arm, circle):
    elastic = elastic_law(RigidArm(with_friction_on_the_arm))
    law = ModelLaw(machine=Machine(robot=with_friction_on_the_arm), elastic=elastic)
    np.testing.assert_allclose(law.torque(circle), elastic.torque(circle), rtol=0, atol=1e-12)
    for found, wanted in zip(law.own_errors(circle), elastic.own_errors(circle), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9)
    check_samples(law, circle)


@pytest.mark.parametrize("name", ["hardening", "torsional_hysteresis", "load_friction", "kinematic_error", "cogging"])
def test_beside_effects_friction_on_the_arm_is_compensated_too(name, with_friction_on_the_arm, circle):
    machine = machine_with(with_friction_on_the_arm, name)
    without = model_law(machine_with(circle.robot, name), name="without friction on the arm")
    elastic, knowing = elastic_law(RigidArm(with_friction_on_the_arm)), model_law(machine)
    either, other, both = link_misses(circle, machine, [elastic, without, knowing])
    assert both < 0.2 * min(either, other)


def test_samples_and_batches_with_effects_and_friction_on_the_arm_are_the_same_law(
    with_friction_on_the_arm, circle, swing
):
    law = model_law(machine_with(with_friction_on_the_arm, *WITH_MEMORY, *WITHOUT))
    check_samples(law, swing)
    check_batch(law, circle)
    check_side_by_side(law, [swing, circle])


def test_it_rests_where_the_reference_does(arm, circle):
    law = model_law(machine_with(arm.robot, *WITH_MEMORY, *WITHOUT), arm)
    still = circle.t < circle.phases[0].end - law.preview * 0.004
    np.testing.assert_allclose(law.torque(circle)[still], 0.0, atol=5e-3)


def test_what_no_torque_compensates_is_told(arm):
    machine = machine_with(arm.robot, "tool_frame", "cogging", "base_flexibility", "tracker_clock")
    assert [effect.name for effect in left_alone(machine)] == ["tool_frame", "base_flexibility", "tracker_clock"]


# Where it comes from


@pytest.fixture
def file(arm, tmp_path):
    return save_machine(machine_with(arm.robot, "cogging"), tmp_path / "cell.toml", title="cell", source="a test")


def test_a_machine_file_is_an_agent(file, arm, circle):
    setting = AgentSetting.of(arm.robot)
    law = make_law(f"model:{file}", setting)
    assert law.name == find_law_name(f"model:{file}") == "model:cell"
    np.testing.assert_array_equal(law.torque(circle), model_law(machine_with(arm.robot, "cogging"), arm).torque(circle))


def test_other_agents_take_no_file_and_other_robots_are_refused(file, arm, one_axis):
    with pytest.raises(FFGymError, match=r"'elastic' takes no file.*model:FILE does"):
        find_law_name(f"elastic:{file}")
    with pytest.raises(FFGymError, match=r"nowhere\.toml"):
        find_law_name("model:nowhere.toml")
    with pytest.raises(FFGymError, match="differ in joints"):
        make_law(f"model:{file}", AgentSetting.of(one_axis))

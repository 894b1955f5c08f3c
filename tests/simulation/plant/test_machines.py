"""Machines of small robots: what makes two the same, what their files say, and what is drawn."""

import tomllib
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.robot import ModelOptions, load_robot
from ffgym.simulation.plant import (
    Climate,
    LogUniform,
    Machine,
    PlantDistribution,
    Uniform,
    load_machine,
    save_machine,
)
from ffgym.simulation.plant.machine import check_same_controller
from ffgym.simulation.plant.machine_file import climate_toml, is_machine_file, known_robot, robot_reference
from ffgym.simulation.plant.machine_text import machine_text

OPTIONS = ModelOptions(looks=False)


def cogging(robot, amplitude=0.1):
    return EFFECTS["cogging"].on(robot, amplitude=amplitude, cycles=6.0, phase=0.0)


def ripple(robot, amplitude=1e-3):
    return EFFECTS["resolver_ripple"].on(robot, amplitude=amplitude, cycles=2.0, phase=0.0)


def test_what_the_engine_simulates_has_the_fingerprint_of_its_model(two_link):
    assert Machine(robot=two_link).fingerprint("0123456789") == "0123456789"
    digest = Machine(robot=two_link, effects=(cogging(two_link),)).fingerprint("0123456789")
    assert len(digest) == 10
    assert digest != "0123456789"


def test_fingerprints_differ_by_what_acts_beside_the_engine_and_not_by_its_order(two_link):
    effects = cogging(two_link), ripple(two_link)
    warm = Climate(ambient=30.0)

    def reading(period, bits):
        drive = replace(two_link.drive, resolver_period=period)
        return replace(two_link, drive=drive, sensors=replace(two_link.sensors, encoder_bits=bits))

    def late(delay):
        return replace(two_link, drive=replace(two_link.drive, torque_delay=np.full(2, delay)))

    machines = [
        Machine(robot=two_link),
        Machine(robot=two_link, effects=effects),
        Machine(robot=two_link, effects=effects, climate=warm),
        Machine(robot=two_link, effects=effects[:1]),
        Machine(robot=two_link, effects=(cogging(two_link, 0.2),)),
        Machine(robot=two_link, effects=effects[1:]),
        Machine(robot=reading(0.00025, 16)),
        Machine(robot=reading(0.0005, 16)),
        Machine(robot=reading(0.0005, 12)),
        Machine(robot=late(1e-3)),
        Machine(robot=late(2e-3)),
    ]
    prints = [machine.fingerprint("0" * 16) for machine in machines]
    assert len(set(prints)) == len(prints)
    turned = Machine(robot=two_link, effects=effects[::-1])
    assert turned.fingerprint("0" * 16) == prints[1]
    # bits matter to those that read, and a climate where there is an effect
    assert Machine(robot=reading(0.0, 12)).fingerprint("0" * 16) == prints[0]
    assert Machine(robot=reading(0.0, 12), effects=effects).fingerprint("0" * 16) == prints[1]
    assert Machine(robot=two_link, climate=warm).fingerprint("0" * 16) == prints[0]


def test_machines_are_the_same_if_all_their_parts_are(two_link):
    effects, climate = (cogging(two_link),), Climate(ambient=30.0)
    machine = Machine(robot=two_link, effects=effects, climate=climate)
    assert machine.is_as(Machine(robot=two_link, effects=effects, climate=Climate(ambient=30.0)))
    for other in (
        machine.with_robot(replace(two_link)),
        replace(machine, effects=()),
        replace(machine, climate=None),
        replace(machine, climate=Climate(ambient=31.0)),
    ):
        assert not machine.is_as(other)


def test_only_machines_in_a_climate_grow_older(two_link):
    machine = Machine(robot=two_link, climate=Climate(running_since=100.0))
    assert machine.later(50.0).climate.running_since == 150.0
    assert machine.at(7.0).climate.running_since == 7.0
    plain = Machine(robot=two_link)
    assert plain.later(50.0) is plain.at(7.0) is plain


def test_a_rise_of_temperature_is_of_one_joint_or_of_all(two_link):
    for rise in (np.array([3.0]), np.array([3.0, 4.0])):
        assert Machine(robot=two_link, climate=Climate(rise=rise)).climate.rise is not None
    with pytest.raises(FFGymError, match=r"climate\.rise has 3 joints, 'two_link' has 2"):
        Machine(robot=two_link, climate=Climate(rise=np.ones(3)))


@pytest.mark.parametrize("part", [{"robot": "two_link"}, {"climate": 20.0}, {"effects": 3}, {"effects": ["cogging"]}])
def test_a_machine_of_other_parts_is_refused(part, two_link):
    with pytest.raises(FFGymError, match="must be"):
        Machine(**{"robot": two_link} | part)


def test_resolvers_read_angles_with_one_error_after_the_other(two_link):
    wave = ripple(two_link)
    machine = Machine(robot=two_link, effects=(wave, cogging(two_link), wave))
    angle, speed = np.array([0.4, 1.1]), np.array([2.0, -3.0])
    once = angle + 1e-3 * np.sin(2 * angle)
    first = speed + 1e-3 * 2 * np.cos(2 * angle) * speed
    twice = once + 1e-3 * np.sin(2 * once)
    second = first + 1e-3 * 2 * np.cos(2 * once) * first
    found = machine.read_by_resolver(angle, speed)
    np.testing.assert_allclose(found, [twice, second], rtol=1e-12)
    assert machine.added_torques == machine.effects[1:2]
    assert machine.resolver_effects == (wave, wave)


def test_only_where_the_engine_computes_no_torques_the_lag_of_drives_is_an_effect(two_link):
    drive = replace(two_link.drive, torque_lag=np.array([1e-3, 2e-3]), torque_delay=np.array([5e-4, 0.0]))
    machine = Machine(robot=replace(two_link, drive=drive), effects=(cogging(two_link),))
    (_, in_plant), (_, without_engine) = machine.torque_effects, machine.torque_effects_without_engine
    assert in_plant.delay.tolist() == without_engine.delay.tolist() == [5e-4, 0.0]
    assert in_plant.lag.tolist() == [0.0, 0.0]
    assert without_engine.lag.tolist() == [1e-3, 2e-3]


def test_what_an_effect_acts_on_may_be_left_out_where_the_effect_is_nothing(two_link):
    stiff = ModelOptions(looks=False, flexible=False)
    for lost, fits in ((1e-4, False), (0.0, True)):
        machine = Machine(robot=two_link, effects=(EFFECTS["torsional_hysteresis"].on(two_link, lost_motion=lost),))
        machine.spec(OPTIONS)
        if fits:
            machine.spec(stiff)
        else:
            with pytest.raises(FFGymError, match="elasticity of joints"):
                machine.spec(stiff)


def test_controllers_are_made_for_joints_gears_servos_and_sample_times(two_link):
    drive, servo = two_link.drive, two_link.servo
    check_same_controller(two_link, replace(two_link, drive=replace(drive, rotor_inertia=2 * drive.rotor_inertia)))
    others = {
        "drive.gear_ratio": replace(two_link, drive=replace(drive, gear_ratio=2 * drive.gear_ratio)),
        "drive.coupling": replace(two_link, drive=replace(drive, coupling=np.array([[0.0, 0.0], [1.0, 0.0]]))),
        "having a tool": replace(two_link, tool=None, geoms=()),
        "simulation.physics_dt": replace(two_link, physics_dt=two_link.physics_dt / 2),
        "servo.integral_gain": replace(two_link, servo=replace(servo, integral_gain=2 * servo.integral_gain)),
        "servo.control_dt": replace(two_link, servo=replace(servo, control_dt=2 * servo.control_dt)),
    }
    for name, other in others.items():
        with pytest.raises(FFGymError, match=f"differ in {name}"):
            check_same_controller(two_link, other)


def test_a_file_says_what_differs_from_the_robot_and_nothing_else(two_link, tmp_path):
    drive = replace(two_link.drive, joint_stiffness=1.1 * two_link.drive.joint_stiffness)
    climate = Climate(ambient=15.0, rise=np.array([3.0, 4.0]), time_constant=600.0, running_since=60.0)
    machine = Machine(robot=replace(two_link, drive=drive), effects=(cogging(two_link),), climate=climate)
    path = save_machine(machine, tmp_path / "m.toml", title="a cell", source="a test")
    tables = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("[")]
    assert tables == ["[machine]", "[drive.joint_stiffness]", "[effects.cogging]", "[climate]"]
    read = load_machine(path)
    assert read.physics(OPTIONS) == machine.physics(OPTIONS)
    assert read.climate.key == climate.key
    assert is_machine_file(path)
    assert robot_reference(path) == "two_link"
    np.testing.assert_array_equal(known_robot(path).drive.joint_stiffness, two_link.drive.joint_stiffness)
    bare = machine_text(Machine(robot=two_link), title="bare", source="a test")
    assert [line for line in bare.splitlines() if line.startswith("[")] == ["[machine]"]


def test_numbers_of_a_file_keep_their_source_until_they_change(two_link, tmp_path):
    drive, friction = two_link.drive, two_link.friction
    stiffer = replace(drive, joint_stiffness=1.1 * drive.joint_stiffness)
    robot = replace(two_link, drive=stiffer, friction=friction.scale(viscous=1.2))
    path = save_machine(Machine(robot=robot), tmp_path / "m.toml", title="t", source="first")
    again = load_machine(path).robot
    again = replace(
        again,
        drive=replace(again.drive, joint_stiffness=drive.joint_stiffness / 2),
        friction=again.friction.scale(coulomb=0.9, static=0.9),
    )
    tables = tomllib.loads(machine_text(Machine(robot=again), title="t", source="second"))
    assert tables["friction"]["viscous"]["source"] == "first"
    assert tables["drive"]["joint_stiffness"]["source"] == "second"
    assert tables["friction"]["coulomb"]["source"] == "second"


def test_a_rating_of_the_description_that_the_robot_lacks_is_not_written(two_link, tmp_path):
    text = (resources.files("ffgym.robot") / "data" / "two_link.toml").read_text(encoding="utf-8")
    rating = '[drive.rated_torque]\nvalue = [20, 10]\nunit = "N m"\nside = "motor"\norigin = "chosen"\nsource = "-"\n'
    (tmp_path / "rated.toml").write_text(f"{text}\n{rating}", encoding="utf-8")
    assert load_robot(tmp_path / "rated.toml").drive.rated_torque.tolist() == [20.0, 10.0]
    worn = replace(two_link, friction=two_link.friction.scale(viscous=1.2))
    path = save_machine(Machine(robot=worn), tmp_path / "m.toml", title="t", source="s", robot=tmp_path / "rated.toml")
    assert [*tomllib.loads(path.read_text(encoding="utf-8"))] == ["machine", "friction"]
    assert load_machine(path).physics(OPTIONS) == Machine(robot=worn).physics(OPTIONS)


def test_what_is_no_machine_file_is_told(tmp_path):
    for name, text, expected in (
        ("a.toml", "[machine]\n", True),
        ("b.toml", "[robot]\n", False),
        ("c.txt", "[machine]\n", False),
        ("d.toml", "[machine", False),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert is_machine_file(tmp_path / name) is expected
    assert not is_machine_file(tmp_path / "e.toml")


def test_a_machine_file_must_end_in_toml_and_name_a_robot_that_it_can_find(two_link, tmp_path):
    with pytest.raises(FFGymError, match=r"ends in \.toml"):
        save_machine(Machine(robot=two_link), tmp_path / "m.txt", title="t", source="s")
    own = replace(two_link, name="mine")
    with pytest.raises(FFGymError, match="'mine' is not built in"):
        machine_text(Machine(robot=own), title="t", source="s")
    longer = replace(two_link, kinematics=replace(two_link.kinematics, position=1.1 * two_link.kinematics.position))
    with pytest.raises(FFGymError, match="differ in geometry"):
        machine_text(Machine(robot=longer), title="t", source="s")


def test_a_climate_is_written_with_its_units():
    text = climate_toml(Climate(ambient=15.0), "a test")
    for name, unit in (("ambient", "degC"), ("rise", "K"), ("time_constant", "s"), ("running_since", "s")):
        (line,) = [line for line in text.splitlines() if line.startswith(name)]
        assert f'unit = "{unit}"' in line


# draws


def drawn(robot, **groups):
    """A robot of which only these groups are drawn, each the same number."""
    none = dict.fromkeys(PlantDistribution.__dataclass_fields__)
    given = {name: Uniform(value, value) for name, value in groups.items()}
    return PlantDistribution(**none | given).draw(robot, np.random.default_rng(0))


def test_factors_are_on_the_numbers_of_their_group(two_link):
    values = {"friction_level": 1.1, "viscous": 1.2, "joint_stiffness": 1.44, "link_inertia": 1.5, "rotor_inertia": 1.6}
    robot = drawn(two_link, **values)
    for part, name, factor in (
        ("friction", "coulomb", 1.1),
        ("friction", "static", 1.1),
        ("friction", "viscous", 1.2),
        ("drive", "joint_stiffness", 1.44),
        ("drive", "joint_damping", 1.2),
        ("bodies", "mass", 1.5),
        ("bodies", "inertia", 1.5),
        ("drive", "rotor_inertia", 1.6),
        ("friction", "stribeck_velocity", 1.0),
        ("bodies", "com", 1.0),
    ):
        mine, nominal = (getattr(getattr(each, part), name) for each in (robot, two_link))
        np.testing.assert_allclose(mine, factor * nominal, rtol=1e-14, err_msg=name)
    assert robot.tool.mass == two_link.tool.mass
    assert drawn(two_link, payload=2.0).tool.mass == two_link.tool.mass + 2.0


def test_factors_on_the_path_of_torque_are_on_the_drives_own_numbers(two_link):
    own = {"torque_lag": [1e-3, 2e-3], "torque_delay": [5e-4, 0.0], "torque_rate": [4e3, 6e3]}
    given = replace(two_link, drive=replace(two_link.drive, **{name: np.array(own[name]) for name in own}))
    drive = drawn(given, torque_lag=2.0, torque_delay=1.5, torque_rate=0.25).drive
    np.testing.assert_allclose(drive.torque_lag, [2e-3, 4e-3], rtol=1e-14)
    np.testing.assert_allclose(drive.torque_delay, [7.5e-4, 0.0], rtol=1e-14)
    np.testing.assert_allclose(drive.torque_rate, [1e3, 1.5e3], rtol=1e-14)


def test_by_default_friction_changes_most_and_masses_least():
    """Percent that drawn numbers lie below and above the nominal ones at most."""
    wanted = {
        "friction_level": (-30, 40),
        "viscous": (-40, 60),
        "stribeck_velocity": (-30, 40),
        "bristle_stiffness": (-30, 40),
        "bristle_damping": (-30, 40),
        "joint_stiffness": (-15, 15),
        "link_inertia": (-5, 5),
        "rotor_inertia": (-3, 3),
    }
    default = PlantDistribution()
    for name, (low, high) in wanted.items():
        values = getattr(default, name).draw(np.random.default_rng(1), 4000)
        np.testing.assert_allclose(
            [values.min(), values.max()], [1 + low / 100, 1 + high / 100], rtol=2e-3, err_msg=name
        )
    mass = default.payload.draw(np.random.default_rng(1), 4000)
    np.testing.assert_allclose([mass.min(), mass.max()], [0.0, 5.0], atol=0.01)
    changing = {name for name in PlantDistribution.__dataclass_fields__ if getattr(default, name) is not None}
    assert changing == {*wanted, "payload"}


def test_shares_are_drawn_on_joints_that_have_one_or_on_all(two_link):
    assert drawn(two_link, arm_share=0.3).friction.arm_share.tolist() == [0.3, 0.3]
    one = replace(two_link, friction=replace(two_link.friction, arm_share=np.array([0.5, 0.0])))
    assert drawn(one, arm_share=0.3).friction.arm_share.tolist() == [0.3, 0.0]
    assert drawn(one, viscous=1.1).friction.arm_share.tolist() == [0.5, 0.0]


@pytest.mark.parametrize("group", ["joint_stiffness", "link_inertia", "rotor_inertia"])
def test_a_factor_of_nothing_is_refused(group, two_link):
    with pytest.raises(FFGymError, match=r"= \[0\. 0\.\] must be > 0"):
        drawn(two_link, **{group: 0.0})


def test_a_robot_without_a_tool_carries_no_payload(one_axis):
    assert one_axis.tool is None
    assert drawn(one_axis, payload=2.0).tool is None


def test_numbers_are_drawn_between_both_ends_evenly_or_in_the_logarithm():
    even = Uniform(2.0, 4.0).draw(np.random.default_rng(0), 4000)
    ratio = LogUniform(0.5, 8.0).draw(np.random.default_rng(0), 4000)
    assert even.shape == ratio.shape == (4000,)
    assert 2.0 <= even.min() < 2.01 < 3.99 < even.max() <= 4.0
    assert 0.5 <= ratio.min() < 0.505 < 7.9 < ratio.max() <= 8.0
    assert np.mean(even) == pytest.approx(3.0, abs=0.05)
    assert np.exp(np.mean(np.log(ratio))) == pytest.approx(2.0, rel=0.06)
    for kind in (Uniform, LogUniform):
        assert kind(3.0, 3.0).draw(np.random.default_rng(0), 2) == pytest.approx(3.0)
        with pytest.raises(FFGymError, match="high"):
            kind(3.0, 2.0)
    with pytest.raises(FFGymError, match="low"):
        LogUniform(0.0, 2.0)

"""Extended models: every cause becomes an effect with the right numbers, and a file that everything accepts."""

import tomllib
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401 - registers the environments
from ffgym.core.errors import FFGymError
from ffgym.diagnosis.extended import extend_machine, save_extended
from ffgym.diagnosis.result import Cause, Diagnosis, Size
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import ModelOptions, load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Climate, Machine, load_machine
from ffgym.simulation.plant.machine_file import known_robot, origins_of, robot_reference
from tests.diagnosis.result_samples import full_diagnosis

OPTIONS = ModelOptions(looks=False)
PARTS = {"vector": (".x", ".y", ".z"), "pair": (".j6",)}


def cause(effect, joint="j2", **values):
    """A cause whose numbers are known within a fifth."""
    kind = EFFECTS[effect]
    sizes = []
    for name, value in values.items():
        known = kind.parameters()[name]
        for part in PARTS.get(known.per, ("",)):
            ends = sorted((0.8 * value, 1.2 * value))
            sizes.append(Size(name=name + part, value=value, unit=known.unit, interval=tuple(ends)))
    whole = all(known.per in ("machine", "vector") for known in kind.parameters().values())
    return Cause(
        effect=effect,
        code=kind.code,
        title=kind.title,
        joint="" if whole else joint,
        parameters=tuple(sizes),
        fixed={},
        held_out_gain=0.9,
    )


def any_cause(effect):
    """A cause of any effect, with all sizes at half of their plausible range."""
    known = EFFECTS[effect].parameters().values()
    far = {p.name: max((p.low, p.high), key=lambda end, p=p: abs(end - p.neutral)) for p in known if p.null is not None}
    return cause(effect, **{name: p / 2 if effect != "stribeck_exponent" else p for name, p in far.items()})


def diagnosis_of(*causes) -> Diagnosis:
    return replace(full_diagnosis(), verdict="named", causes=causes, numbers=())


@pytest.mark.parametrize("name", list(EFFECTS))
def test_every_effect_of_the_library_can_be_a_cause_and_is_read_back_to_the_bit(name, irb4600, tmp_path):
    nominal, path = Machine(robot=irb4600), tmp_path / "extended.toml"
    diagnosis = diagnosis_of(any_cause(name))
    machine = save_extended(path, diagnosis, nominal)
    (effect,) = machine.effects
    assert not effect.is_null
    assert machine.physics(OPTIONS) == load_machine(path).physics(OPTIONS)
    for known in effect.parameters().values():
        if known.per == "joint" and known.null is not None:
            np.testing.assert_array_equal(np.delete(getattr(effect, known.name), 1), known.null)


def test_numbers_stand_where_the_cause_says(irb4600):
    causes = [
        cause("load_friction", "j3", share=0.07),
        cause("tool_frame", offset=1e-3),
        cause("wrist_coupling", "j5", share=0.1),
        replace(cause("cogging", "j1", amplitude=0.1), fixed={"cycles": 12.0, "phase": 0.5}),
    ]
    load, frame, wrist, cogging = extend_machine(Machine(robot=irb4600), causes).effects
    np.testing.assert_array_equal(load.share, [0, 0, 0.07, 0, 0, 0])
    np.testing.assert_array_equal(frame.offset, np.full(3, 1e-3))
    assert wrist.share[4, 5] == 0.1
    assert np.count_nonzero(wrist.share) == 1
    assert (cogging.amplitude[0], cogging.cycles[0], cogging.phase[0]) == (0.1, 12.0, 0.5)


def test_every_number_says_where_it_comes_from_and_how_sure_it_is(irb4600, tmp_path):
    path = tmp_path / "extended.toml"
    said = replace(cause("load_friction", "j3", share=0.05), fixed={})
    save_extended(path, diagnosis_of(said), Machine(robot=irb4600))
    (origin,) = origins_of(path)
    assert origin.label == "j3"
    assert "diagnosed on j3 from diagnosis.slow_triangle, diagnosis.sine" in origin.sources["share"]
    assert "before 0" in origin.sources["share"]
    np.testing.assert_allclose(origin.intervals["share"][2], [0.04, 0.06])
    np.testing.assert_array_equal(origin.intervals["share"][0], [0.0, 0.0])


def test_the_next_diagnosis_goes_on_with_what_the_last_one_found(irb4600, tmp_path):
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    save_extended(first, diagnosis_of(cause("load_friction", "j2", share=0.05)), Machine(robot=irb4600))
    nominal = load_machine(first)
    found = diagnosis_of(cause("load_friction", "j3", share=0.07), cause("coulomb_level", "j3", change=-0.2))
    save_extended(second, found, nominal, robot=robot_reference(first), origins=origins_of(first))
    before, after = origins_of(first), origins_of(second)
    assert [origin.label for origin in after] == ["j2", "j3", "j3"]
    assert after[0].sources == before[0].sources
    np.testing.assert_array_equal(after[0].intervals["share"], before[0].intervals["share"])
    assert [effect.name for effect in load_machine(second).effects] == [
        "load_friction",
        "load_friction",
        "coulomb_level",
    ]


def test_the_file_names_its_robot_from_wherever_it_lies(one_axis_text, tmp_path):
    (tmp_path / "robots").mkdir()
    (tmp_path / "deep" / "er").mkdir(parents=True)
    description = tmp_path / "robots" / "mine.toml"
    description.write_text(one_axis_text.replace('name = "one_axis"', 'name = "mine"'), encoding="utf-8")
    nominal, path = Machine(robot=load_robot(description)), tmp_path / "deep" / "er" / "extended.toml"
    save_extended(path, diagnosis_of(cause("cogging", "j1", amplitude=0.1)), nominal, robot=description)
    assert load_machine(path).robot.name == nominal.robot.name
    assert tomllib.loads(path.read_text(encoding="utf-8"))["machine"]["robot"] == "../../robots/mine.toml"


def test_parameters_that_ship_can_be_the_nominal_model(tmp_path):
    name = "irb4600_60_205_commissioned"
    nominal, path = Machine(robot=load_robot(name)), tmp_path / "extended.toml"
    save_extended(path, diagnosis_of(cause("coulomb_level", "j1", change=0.2)), nominal, robot=name)
    np.testing.assert_array_equal(known_robot(path).friction.coulomb, nominal.robot.friction.coulomb)
    assert load_machine(path).physical.friction.coulomb[0] == pytest.approx(1.2 * nominal.robot.friction.coulomb[0])


def test_a_machine_is_as_warm_as_its_recordings_say(irb4600, corners, tmp_path):
    path = multisine(corners["p1"], np.full((1, 6), 0.01), [2.0], np.zeros((1, 6)), 0.2, ramp=0.05, dwell=0.05)
    day = Climate(ambient=22.0, rise=np.linspace(0.0, 20.0, 6), running_since=3600.0)
    reference = joint_reference(irb4600, path)
    recordings = simulate([Run(reference=reference)], machine=Machine(robot=irb4600, climate=day), n_threads=1)
    file, found = tmp_path / "extended.toml", diagnosis_of(cause("temperature_friction", viscous=0.3, coulomb=0.01))
    with pytest.raises(FFGymError, match="does not say breakaway"):
        save_extended(file, found, Machine(robot=irb4600), recordings=recordings)
    found = diagnosis_of(cause("temperature_friction", viscous=0.3, coulomb=0.01, breakaway=0.01))
    save_extended(file, found, Machine(robot=irb4600), recordings=recordings)
    warm = load_machine(file).climate.temperature(np.array([0.0, 1.0, 100.0]), 6)
    measured = recordings[0].joint_array("temperature").mean(axis=0)
    np.testing.assert_allclose(warm[1:], [measured, measured], atol=1e-9)
    silent = simulate([Run(reference=reference)], n_threads=1)
    assert save_extended(file, found, Machine(robot=irb4600), recordings=silent).climate is None


def test_an_environment_takes_it_as_its_plant(irb4600, tmp_path):
    path = tmp_path / "extended.toml"
    save_extended(path, diagnosis_of(cause("load_friction", share=0.05)), Machine(robot=irb4600))
    env = gym.make("ffgym/CirclePath-v0", plant=path)
    env.reset(seed=0)
    assert [effect.name for effect in env.unwrapped.core.plant.machines[0].effects] == ["load_friction"]
    env.close()


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"effect": "magic"}, "Unknown effect of a cause 'magic'"),
        ({"joint": "j9"}, "Unknown joint of cause load_friction 'j9'"),
        ({"parameters": ()}, "does not say share"),
        ({"fixed": {"colour": 1.0}}, "Unknown parameter of load_friction 'colour'"),
    ],
)
def test_a_cause_that_fits_nothing_is_refused_by_name_and_nothing_is_written(wrong, says, irb4600, tmp_path):
    bad = replace(cause("load_friction", share=0.05), **wrong)
    with pytest.raises(FFGymError, match=says):
        save_extended(tmp_path / "extended.toml", diagnosis_of(bad), Machine(robot=irb4600))
    assert list(tmp_path.iterdir()) == []

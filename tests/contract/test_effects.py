"""What every physical effect must do; a new member of the catalogue is picked up by itself."""

import tomllib
from dataclasses import fields

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS, ModelEffect, effects_toml, read_effects
from ffgym.paths import joint_reference, multisine
from ffgym.robot import builtin_robots, load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Climate, Machine, Plant
from tests.effects.effect_samples import as_strong_as_plausible, without_effect

BY_NAME = pytest.mark.parametrize("effect", list(EFFECTS.values()), ids=list(EFFECTS))
WARM = Climate(ambient=20.0, rise=np.array([25.0]), time_constant=1200.0, running_since=3600.0)
STARTED = Climate(ambient=20.0, rise=np.array([25.0]), time_constant=1200.0)


@pytest.fixture(scope="module")
def motion(irb4600, corners):
    """All joints swing about a pose of the work area, from rest to rest."""
    amplitude = np.full((1, irb4600.n_joints), 0.004)
    return joint_reference(
        irb4600, multisine(corners["p1"], amplitude, [2.0], np.zeros((1, 6)), 0.8, ramp=0.3, dwell=0.1)
    )


def recorded(motion, machine, record_dt=0.001):
    return simulate([Run(reference=motion)], machine=machine, record_dt=record_dt, n_threads=1)[0]


@pytest.fixture(scope="module")
def nominal(motion, irb4600):
    return recorded(motion, Machine(robot=irb4600, climate=WARM))


@BY_NAME
def test_an_effect_says_what_it_is(effect):
    assert effect.code
    for text in (effect.name, effect.title, effect.equation, effect.signature, effect.way_in):
        assert text == text.strip() != ""
    assert effect.parameters()
    assert set(effect.parameters()) == {f.name for f in fields(effect)}
    for known in effect.parameters().values():
        assert known.low < known.high
        assert known.minimum <= known.low
        assert known.high <= known.maximum
        assert known.source
        assert known.unit
    assert any(known.null is not None for known in effect.parameters().values())


@BY_NAME
def test_at_its_null_value_it_changes_nothing(effect, motion, nominal, irb4600):
    null = without_effect(effect, irb4600)
    assert null.is_null
    same = recorded(motion, Machine(robot=irb4600, effects=(null,), climate=WARM))
    for column in same.columns:
        np.testing.assert_allclose(same[column], nominal[column], rtol=0, atol=1e-12, err_msg=column)


@BY_NAME
def test_at_its_strongest_it_shows_and_stays_finite(effect, motion, nominal, irb4600):
    strong = as_strong_as_plausible(effect, irb4600)
    assert not strong.is_null
    changed = recorded(motion, Machine(robot=irb4600, effects=(strong,), climate=WARM))
    families = [c for c in changed.columns if c.startswith(("motor.", "link.", "tcp.position", "command."))]
    difference = max(np.abs(changed[c] - nominal[c]).max() for c in families)
    assert 1e-6 < difference < 10


@BY_NAME
def test_on_one_joint_it_leaves_the_numbers_of_others_alone(effect, irb4600):
    for name, known in effect.parameters().items():
        if known.per == "joint" and known.null is not None:
            values = {n: k.high for n, k in effect.parameters().items()}
            value = getattr(effect.on(irb4600, "j3", **values), name)
            assert value[2] == known.high
            assert np.all(np.delete(value, 2) == known.null)


@BY_NAME
def test_a_machine_does_not_depend_on_its_neighbours(effect, motion, irb4600):
    strong = Machine(robot=irb4600, effects=(as_strong_as_plausible(effect, irb4600),), climate=STARTED)
    alone = recorded(motion, strong)
    plain = Machine(robot=irb4600)
    if issubclass(effect, ModelEffect) or effect.name == "arm_friction":  # more in the engine than the others have
        with pytest.raises(FFGymError, match="in a batch of its own"):
            simulate([Run(reference=motion)] * 2, machine=[plain, strong], n_threads=1)
        return
    together = simulate([Run(reference=motion)] * 3, machine=[plain, strong, plain], n_threads=1)
    assert together[1].equals(alone)
    assert together[0].equals(together[2])
    assert together[0].equals(recorded(motion, plain))


@BY_NAME
def test_it_is_written_and_read_back_to_the_bit(effect, irb4600):
    members = [as_strong_as_plausible(effect, irb4600), without_effect(effect, irb4600)]
    tree = tomllib.loads(effects_toml(members, "a test"))
    for before, after in zip(members, read_effects(tree["effects"], irb4600), strict=True):
        assert type(after) is effect
        for name, value in before.values().items():
            np.testing.assert_array_equal(getattr(after, name), value)


@BY_NAME
def test_it_refuses_values_that_are_none(effect, irb4600):
    for name, known in effect.parameters().items():
        for bad in (np.nan, "much", np.ones(7), [], [[0.1], [0.1, 0.2]], True, 10**400, None):
            values = {n: k.high for n, k in effect.parameters().items()} | {name: bad}
            with pytest.raises(FFGymError, match=rf"{effect.name}|{name}"):
                Machine(robot=irb4600, effects=(effect(**values),))
            with pytest.raises(FFGymError, match=rf"{effect.name}\.{name}"):
                effect.on(irb4600, **values)
        if np.isfinite(known.maximum):
            with pytest.raises(FFGymError, match="at most"):
                effect.on(irb4600, **{n: k.high for n, k in effect.parameters().items()} | {name: known.maximum + 1})
        if np.isfinite(known.minimum):
            with pytest.raises(FFGymError, match="at least"):
                effect.on(irb4600, **{n: k.high for n, k in effect.parameters().items()} | {name: known.minimum - 1})


def test_codes_and_names_are_used_once():
    assert len({effect.code for effect in EFFECTS.values()}) == len(EFFECTS)
    assert all(effect.name == name for name, effect in EFFECTS.items())


@pytest.mark.parametrize("name", builtin_robots())
@BY_NAME
def test_any_robot_has_it_or_is_refused_with_a_reason(effect, name):
    robot = load_robot(name)
    home = np.zeros(robot.n_joints) if robot.work_area is None else robot.work_area.home
    try:
        machine = Machine(robot=robot, effects=(as_strong_as_plausible(effect, robot, share=0.3),), climate=WARM)
    except FFGymError as error:
        assert effect.name in str(error)  # noqa: PT017  # either is right
        return
    plant = Plant(machine, 1, n_threads=1)
    plant.rest(np.clip(home, *robot.kinematics.range.T)[None])
    plant.drive(np.zeros((1, 4, plant.model.nu)))
    assert np.isfinite(plant.state().link_position).all()

"""The model that is written is the one that was measured: causes, and the numbers that were fitted beside them."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis import examine
from ffgym.diagnosis.diagnosis_file import diagnosis_document, parse_diagnosis
from ffgym.diagnosis.extended import extend_machine, save_extended
from ffgym.diagnosis.held_out import compare_replays
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import ModelOptions, load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine, load_machine

KNOWN = ParameterPrior.of_share(0.03)


def motions(robot, seeds):
    """References of swings with several sines, each with phases of its own."""
    centre = robot.kinematics.range.mean(axis=1)
    found = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        amplitude, phases = rng.uniform(0.1, 0.3, (3, 1)), rng.uniform(0, 6, (3, 1))
        sines = multisine(centre, amplitude, [0.3, 0.8, 1.7], phases, 8.0, ramp=1.0, dwell=0.3)
        found.append(joint_reference(robot, sines))
    return found


def recorded(machine, seeds):
    """What such a machine's log has, with noise."""
    runs = [Run(reference=reference) for reference in motions(machine.robot, seeds)]
    found = []
    for seed, recording in zip(seeds, simulate(runs, machine=machine, record_dt=0.002, n_threads=1), strict=True):
        rng, n = np.random.default_rng(seed), len(recording)
        columns = {
            "timestamp": recording.t,
            "motor.position.j1": recording["motor.position.j1"] + rng.normal(scale=2e-5, size=n),
            "motor.effort.j1": recording["motor.effort.j1"] + rng.normal(scale=0.01, size=n),
        }
        found.append(type(recording)(columns, recording.header).rename(f"swing {seed}"))
    return found


def off(robot, **factors):
    """The robot with other numbers than its description."""
    friction = {name: getattr(robot.friction, name) * x for name, x in factors.items() if hasattr(robot.friction, name)}
    drive = {name: getattr(robot.drive, name) * x for name, x in factors.items() if hasattr(robot.drive, name)}
    return replace(robot, friction=replace(robot.friction, **friction), drive=replace(robot.drive, **drive))


@pytest.fixture(scope="module")
def cogging():
    """An axis that cogs, with friction levels some per cent other than described; and its diagnosis."""
    robot = load_robot("one_axis")
    hidden = EFFECTS["cogging"].on(robot, amplitude=0.06, cycles=6.0, phase=0.4)
    machine = Machine(robot=off(robot, coulomb=1.06, static=1.06, viscous=0.92), effects=(hidden,))
    return machine, examine(robot, recorded(machine, (1, 2, 3, 4)), prior=KNOWN)


def test_numbers_that_were_fitted_beside_a_cause_are_in_the_model_with_their_values(cogging):
    machine, examined = cogging
    assert [cause.effect for cause in examined.diagnosis.causes] == ["cogging"]
    numbers = {number.entry: number for number in examined.diagnosis.numbers}
    friction = machine.robot.friction
    for entry, true in (("friction.coulomb", friction.coulomb), ("friction.viscous", friction.viscous)):
        before, after = numbers[entry].before[0], numbers[entry].after[0]
        assert abs(after - true[0]) < 0.35 * abs(before - true[0])


def test_the_model_with_its_numbers_foretells_other_motions_better_than_with_the_cause_alone(cogging):
    machine, examined = cogging
    others = recorded(machine, (11, 12))
    alone = extend_machine(examined.nominal, examined.diagnosis.causes)
    nominal, bare, whole = (
        compare_replays(examined.nominal, model, others)[0].after
        for model in (examined.nominal, alone, examined.machine)
    )
    assert whole < 0.8 * bare < 0.8 * nominal
    assert examined.diagnosis.gains
    (level,) = [level for level in examined.diagnosis.levels if level.channel == "torque"]
    assert level.before == pytest.approx(nominal, rel=0.15)  # what is told is what models leave of other motions
    assert level.after < 0.7 * level.before


def test_the_file_and_the_document_say_the_same_model(cogging, tmp_path):
    _, examined = cogging
    path, options = tmp_path / "extended.toml", ModelOptions(looks=False)
    save_extended(path, examined.diagnosis, examined.nominal)
    physics = examined.machine.physics(options)
    assert load_machine(path).physics(options) == physics
    read = parse_diagnosis(diagnosis_document(examined.diagnosis))
    assert extend_machine(examined.nominal, read.causes, read.numbers).physics(options) == physics
    assert "fitted beside the causes to swing 1" in path.read_text(encoding="utf-8")


def test_a_number_that_is_a_cause_is_one_number_and_no_calibration_error_beside_it():
    robot = load_robot("one_axis")
    machine = Machine(robot=off(robot, viscous=1.4))
    diagnosis = examine(robot, recorded(machine, (1, 2, 3)), prior=KNOWN).diagnosis
    (cause,) = diagnosis.causes
    assert (cause.effect, cause.joint) == ("viscous_level", "j1")
    (size,) = cause.parameters
    assert size.value == pytest.approx(0.4, abs=0.02)  # all of it, not what lies beyond four standard deviations
    assert "friction.viscous" not in {number.entry for number in diagnosis.numbers}


def test_a_number_without_a_place_in_the_robot_is_one_clear_error(cogging):
    _, examined = cogging
    (number, *_) = examined.diagnosis.numbers
    with pytest.raises(FFGymError, match=r"has 2 values, which robot 'one_axis' has no place for"):
        extend_machine(examined.nominal, (), [replace(number, after=(1.0, 2.0))])

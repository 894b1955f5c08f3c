"""Machines in files."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.robot import ModelOptions
from ffgym.simulation.plant import Climate, Machine, Plant, load_machine, save_machine, with_payload
from ffgym.simulation.plant.machine_file import is_machine_file

HEAD = '[machine]\ntitle = "cell 3"\nrobot = "irb4600_60_205"\n'


def written(tmp_path, text):
    path = tmp_path / "machine.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def worn(irb4600):
    """Another stiffness and friction, a payload, two effects of one kind, and a climate."""
    robot = replace(
        irb4600,
        friction=irb4600.friction.scale(coulomb=0.9),
        drive=replace(irb4600.drive, joint_stiffness=irb4600.drive.joint_stiffness * 1.1),
    )
    effects = (
        EFFECTS["load_friction"].on(robot, share=0.06),
        EFFECTS["cogging"].on(robot, "j2", amplitude=0.1),
        EFFECTS["cogging"].on(robot, amplitude=0.02, cycles=6.0),
    )
    climate = Climate(rise=np.linspace(10.0, 20.0, 6), running_since=600.0)
    return Machine(robot=with_payload(robot, 3.0), effects=effects, climate=climate)


def test_a_machine_is_written_and_read_back_to_the_bit(worn, tmp_path):
    path = save_machine(worn, tmp_path / "worn.toml", title='the "worn" \U0001f916 one', source="a test\x7f\n")
    assert is_machine_file(path)
    options = ModelOptions(looks=False)
    assert load_machine(path).physics(options) == worn.physics(options)


def test_a_file_of_a_head_alone_is_the_robot_itself(irb4600, tmp_path):
    machine = load_machine(written(tmp_path, HEAD))
    options = ModelOptions(looks=False)
    assert machine.effects == ()
    assert machine.climate is None
    assert machine.physics(options) == Machine(robot=irb4600).physics(options)


def test_the_robot_may_be_a_description_beside_the_file(one_axis_text, tmp_path):
    (tmp_path / "cell.toml").write_text(one_axis_text, encoding="utf-8")
    machine = load_machine(written(tmp_path, '[machine]\ntitle = "cell"\nrobot = "cell.toml"\n'))
    assert machine.robot.name == "one_axis"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "no table"),
        ("[machine]\n", "title and robot"),
        ('[machine]\ntitle = "x"\nrobot = 3\n', "both text"),
        (HEAD.replace("irb4600_60_205", "r2d2"), "Unknown robot"),
        (HEAD.replace("irb4600_60_205", "nowhere.toml"), "nowhere.toml"),
        (HEAD + "[servo]\n", "Unknown table 'servo'"),
        (HEAD + "[effects.magic]\n", "Unknown effect"),
        (HEAD + "[effects.cogging]\n", "lacks"),
        (HEAD + '[effects.cogging]\namplitude = { value = 1, unit = "N" }\n', "must be 'N m'"),
        (HEAD + '[effects.cogging]\namplitude = { value = -1, unit = "N m" }\n', "at least 0"),
        (HEAD + "effects = 3\n", "must have exactly"),
        (HEAD + '[effects.cogging]\namplitude = { value = [1, 2], unit = "N m" }\n', "has shape (2,), must be (6)"),
        (HEAD + '[effects.cogging]\namplitude = { value = "1", unit = "N m" }\n', "must be numbers, got '1'"),
        (
            HEAD + '[drive.gear_ratio]\nvalue = [9, 9, 9, 9, 9, 9]\nunit = "1"\norigin = "chosen"\nsource = "-"\n',
            "gear",
        ),
        (HEAD.replace("irb4600_60_205", "a\\u0000.toml"), "no name of a file"),
        (HEAD + '[climate]\nrise = { value = [[1], [1, 2]], unit = "K" }\n', "climate.rise must be numbers"),
        (HEAD + '[climate]\nrise = { value = "warm", unit = "K" }\n', "climate.rise must be a number"),
        (HEAD + '[effects.cogging]\namplitude = { value = 1, unit = "N m", source = 3 }\n', "must be text"),
        (HEAD + '[effects.cogging]\namplitude = { value = 1, unit = "N m", interval = [2, 1] }\n', "lower and upper"),
        (HEAD + '[effects.cogging]\namplitude = { value = 1, unit = "N m", interval = "so" }\n', "must be numbers"),
        (HEAD + '[climate]\nambient = { value = 3, unit = "degC", source = 3 }\n', "must be text"),
        (HEAD + "[climate]\nwind = 3\n", "Unknown entry of climate"),
        (HEAD + "[climate]\nambient = 3\n", "table of value, unit"),
        (HEAD + '[climate]\nambient = { value = 3, unit = "K" }\n', "must be 'degC'"),
        (HEAD + '[climate]\nrise = { value = [1, 2], unit = "K" }\n', "has 2 joints"),
        (HEAD + '[climate]\nambient = { value = "warm", unit = "degC" }\n', "must be a number"),
        (HEAD + "[friction.coulomb]\nvalue = 1\n", "friction.coulomb"),
        ("[machine", "not valid TOML"),
    ],
)
def test_what_a_file_gets_wrong_is_said_with_its_name(text, says, tmp_path):
    path = written(tmp_path, text)
    with pytest.raises(FFGymError, match=r"machine\.toml") as error:
        load_machine(path)
    assert says in str(error.value)


def test_only_what_a_file_can_say_is_written(worn, tmp_path):
    with pytest.raises(FFGymError, match="not built in"):
        save_machine(
            replace(worn, robot=replace(worn.robot, name="mine")), tmp_path / "m.toml", title="mine", source="a test"
        )
    for other in (
        replace(worn.robot, servo=replace(worn.robot.servo, position_gain=worn.robot.servo.position_gain * 1.1)),
        replace(worn.robot, servo=replace(worn.robot.servo, control_dt=0.002)),
        replace(worn.robot, kinematics=replace(worn.robot.kinematics, position=worn.robot.kinematics.position * 1.1)),
        replace(worn.robot, tool=None),
    ):
        with pytest.raises(FFGymError, match="differ"):
            save_machine(replace(worn, robot=other), tmp_path / "m.toml", title="mine", source="a test")
    with pytest.raises(FFGymError, match="must be a description"):
        save_machine(None, tmp_path / "m.toml", title="none", source="a test")
    with pytest.raises(FFGymError, match=r"ends in \.toml"):
        save_machine(worn, tmp_path / "m.json", title="mine", source="a test")
    assert list(tmp_path.iterdir()) == []


@given(text=st.text(max_size=60), place=st.integers(0, len(HEAD)))
def test_a_damaged_file_is_refused_or_is_a_machine(text, place, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "damaged.toml"
    path.write_text(HEAD[:place] + text + HEAD[place:], encoding="utf-8", newline="")
    with suppress(FFGymError):
        load_machine(path)


@pytest.mark.parametrize(
    ("name", "values", "options", "part"),
    [
        ("nonlinear_viscous", {"share": -0.3}, {"friction": False}, "friction"),
        ("kinematic_error", {"amplitude": 1e-4}, {"flexible": False}, "elasticity"),
    ],
)
def test_what_an_effect_acts_on_cannot_be_left_out(name, values, options, part, irb4600):
    machine = Machine(robot=irb4600, effects=(EFFECTS[name].on(irb4600, **values),))
    with pytest.raises(FFGymError, match=f"{name} acts in the {part}"):
        Plant(machine, 1, options=ModelOptions(looks=False, **options))
    null = Machine(robot=irb4600, effects=(EFFECTS[name].on(irb4600, **dict.fromkeys(values, 0.0)),))
    Plant(null, 1, options=ModelOptions(looks=False, **options))


def test_an_effect_may_say_how_sure_an_identification_is_of_it(tmp_path):
    numbers = 'amplitude = { value = 0.1, unit = "N m", source = "identified", interval = [0.08, 0.13] }\n'
    (cogging,) = load_machine(written(tmp_path, HEAD + "[effects.cogging]\n" + numbers)).effects
    np.testing.assert_array_equal(cogging.values()["amplitude"], np.full(6, 0.1))


def test_a_machine_is_made_of_what_it_says(irb4600):
    cogging = EFFECTS["cogging"].on(irb4600, amplitude=0.1)
    for wrong in ({"robot": "irb4600_60_205"}, {"climate": 20.0}, {"effects": cogging}, {"effects": [type(cogging)]}):
        with pytest.raises(FFGymError, match=f"{next(iter(wrong))}.* must be"):
            Machine(**{"robot": irb4600} | wrong)
    with pytest.raises(FFGymError, match="cogging lacks"):
        EFFECTS["cogging"].on(irb4600, cycles=2.0)

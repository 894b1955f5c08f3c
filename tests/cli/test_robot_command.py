"""`ffgym robot`: new, fill and check, as a user runs them."""

import json

import pytest

from ffgym.cli.main import main
from ffgym.robot import ModelOptions, compile_model, load_robot, physics_fingerprint
from tests.cli.errors import read_error
from tests.robot.template.arm_xml import ARM, NUMBERS


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Folder with an arm, in which commands run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(ARM)
    return tmp_path


def refusal(capsys, *arguments):
    """The one line with which a command ends that cannot be run."""
    assert main(["robot", *arguments]) == 1
    return read_error(capsys)


def test_from_an_arm_file_to_a_whole_robot(folder, capsys):
    assert main(["robot", "new", "arm.xml", "--out", "cutter.toml"]) == 0
    said = capsys.readouterr().out
    assert (
        "wrote cutter.toml: 6 joints, j1, j2, j3, j4, j5, j6; missing: kinematics.max_speed, drive.gear_ratio" in said
    )
    assert "ffgym robot fill cutter.toml" in said
    table = folder / "cutter.toml"
    table.write_text(table.read_text() + "".join(NUMBERS.values()))
    assert main(["robot", "fill", "cutter.toml"]) == 0
    assert "friction.static: 1.05 x coulomb" in capsys.readouterr().out
    robot = load_robot("cutter.toml")
    assert robot.name == "cutter"
    assert robot.tool is not None
    before = table.read_bytes()
    assert main(["robot", "fill", "cutter.toml"]) == 0
    assert "0 entries filled in; nothing is missing" in capsys.readouterr().out
    assert table.read_bytes() == before


def test_the_arm_is_found_from_wherever_the_table_lies(folder):
    (folder / "robots").mkdir()
    assert main(["robot", "new", "arm.xml", "--out", "robots/cutter.toml"]) == 0
    assert 'model = "../arm.xml"' in (folder / "robots" / "cutter.toml").read_text()


def test_meshes_that_are_missing_can_be_left_out(folder, capsys):
    mesh = '<asset><mesh name="m" file="absent.stl"/></asset><worldbody>'
    text = ARM.replace("<worldbody>", mesh, 1).replace(
        '<site name="tcp"', '<geom type="mesh" mesh="m"/><site name="tcp"'
    )
    (folder / "meshes.xml").write_text(text)
    said = refusal(capsys, "new", "meshes.xml", "--out", "mine.toml")
    assert "absent.stl" in said
    assert "--no-looks" in said
    assert main(["robot", "new", "meshes.xml", "--out", "mine.toml", "--no-looks"]) == 0
    assert main(["robot", "check", "mine.toml"]) == 0


def test_a_table_that_is_there_is_not_written_over_unless_forced(folder, capsys):
    (folder / "mine.toml").write_text("my work")
    assert "mine.toml is there already" in refusal(capsys, "new", "arm.xml", "--out", "mine.toml")
    assert (folder / "mine.toml").read_text() == "my work"
    assert main(["robot", "new", "arm.xml", "--out", "mine.toml", "--force"]) == 0
    assert "[robot]" in (folder / "mine.toml").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["new", "absent.xml"], "absent.xml"),
        (["new", "arm.xml", "--out", "mine.txt"], "a description must end in .toml"),
        (["new", "arm.xml", "--out", "absent/mine.toml"], "does not exist"),
        (["new", "arm.xml", "--joints", "j1", "j9"], "j9"),
        (["new", "arm.xml", "--tool-frame", "hand"], "hand"),
        (["fill", "one_axis"], "must be a description that ends in .toml"),
        (["fill", "absent.toml"], "absent.toml"),
        (["check", "absent.toml"], "absent.toml"),
        (["check", "no_robot"], "Unknown robot 'no_robot'"),
        (["check", "one_axis", "--json", "a", "--report", "a"], "they need two files"),
        (["check", "one_axis", "--json", "absent/a.json"], "does not exist"),
        (["check", "arm.toml", "--json", "arm.xml"], "--json arm.xml: the name must end in .json"),
        (["check", "arm.toml", "--report", "arm.xml"], "--report arm.xml: the name must end in .html"),
        (["check", "arm.toml", "--report", "arm.toml"], "--report arm.toml: is read by this command and would be lost"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_leaves_nothing(folder, capsys, arguments, message):
    assert message in refusal(capsys, *arguments)
    assert [path.name for path in folder.iterdir()] == ["arm.xml"]


def test_a_damaged_table_stays_as_it_is(folder, capsys):
    table = folder / "mine.toml"
    assert main(["robot", "new", "arm.xml", "--out", "mine.toml"]) == 0
    table.write_text(table.read_text() + NUMBERS["friction.coulomb"].replace("N m", "Nm"))
    before = table.read_bytes()
    capsys.readouterr()
    assert "friction.coulomb: unit is 'Nm', must be 'N m'" in refusal(capsys, "fill", "mine.toml")
    assert table.read_bytes() == before


def test_check_prints_what_works_and_writes_every_number(folder, capsys):
    pytest.importorskip("matplotlib")
    assert main(["robot", "check", "one_axis", "--json", "check.json", "--report", "check.html"]) == 0
    said = capsys.readouterr().out
    assert "One-axis model, thesis (2.14) (one_axis), 1 joint: complete." in said
    assert "What works" in said
    assert "Doubts" in said
    numbers = json.loads((folder / "check.json").read_text())
    fingerprint = physics_fingerprint(compile_model(load_robot("one_axis"), ModelOptions(looks=False)))
    assert numbers["physics_fingerprint"] == fingerprint
    assert numbers["seed"] is None
    assert {"versions", "config", "command"} <= numbers.keys()
    assert numbers["missing"] == []
    assert numbers["margin"]["peak"] == [25.0]
    assert numbers["servo"]["stable"] is True
    assert numbers["lacks"]["circles"]
    assert "<html" in (folder / "check.html").read_text()


def test_check_prints_friction_on_the_arm_where_a_robot_has_some(folder, capsys):
    for name, told in (("two_link", False), ("irb4600_60_205_arm_losses", True)):
        assert main(["robot", "check", name]) == 0
        printed = capsys.readouterr().out
        assert ("friction on the arm" in printed) == told
    share = load_robot("irb4600_60_205_arm_losses").arm_share[0]
    assert f"{share:.3g}" in next(line for line in printed.splitlines() if line.startswith("j1 "))


def test_check_of_a_draft_says_what_fill_would_do(folder, capsys):
    assert main(["robot", "new", "arm.xml", "--out", "mine.toml"]) == 0
    with (folder / "mine.toml").open("a") as file:
        file.write(NUMBERS["friction.coulomb"])
    capsys.readouterr()
    assert main(["robot", "check", "mine.toml", "--json", "check.json"]) == 0
    said = capsys.readouterr().out
    assert "ffgym robot fill mine.toml would fill in friction.static, friction.bristle_stiffness" in said
    numbers = json.loads((folder / "check.json").read_text())
    assert numbers["physics_fingerprint"] is None
    assert "drive.gear_ratio" in numbers["missing"]
    assert numbers["gravity"]["motor_worst"] is None
    assert numbers["gravity"]["worst"][1] > 100


@pytest.mark.parametrize(
    ("link", "command"),
    [("arm.toml", ["new", "arm.xml", "--force", "--out"]), ("arm.json", ["check", "arm.xml", "--json"])],
)
def test_what_is_read_is_not_written_over(folder, link, command, capsys):
    (folder / link).symlink_to("arm.xml")
    assert "is read by this command and would be lost" in refusal(capsys, *command, link)
    assert (folder / "arm.xml").read_text() == ARM

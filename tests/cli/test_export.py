"""`ffgym export` writes models that plain MuJoCo loads and runs."""

import mujoco
import numpy as np
import pytest

from ffgym.cli.export import spec_with_home
from ffgym.cli.main import main
from ffgym.robot import ModelOptions, builtin_robots, load_robot, physics_fingerprint


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    """MuJoCo writes MUJOCO_LOG.TXT into the working directory when something is wrong."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")


def stepped(model, steps=400):
    """Final state after holding a bent pose."""
    data = mujoco.MjData(model)
    data.qpos[:] = 0.1
    data.ctrl[:] = 0.0
    mujoco.mj_step(model, data, steps)
    assert [int(w.number) for w in data.warning] == [0] * len(data.warning)
    return np.concatenate([data.qpos, data.qvel, data.act])


def only_line_of_error(capsys):
    out = capsys.readouterr()
    (line,) = out.err.splitlines()
    assert line.startswith("ffgym: error: ")
    assert out.out == ""
    return line


@pytest.mark.parametrize("robot", builtin_robots())
def test_mjcf_runs_in_plain_mujoco_without_warnings_or_stray_files(robot, tmp_path):
    out = tmp_path / "robot.xml"
    assert main(["export", "--robot", robot, "--out", str(out)]) == 0
    model = mujoco.MjModel.from_xml_path(str(out))
    own = spec_with_home(load_robot(robot), ModelOptions()).compile()
    assert (model.nv, model.nu, model.na, model.ngeom) == (own.nv, own.nu, own.na, own.ngeom)
    np.testing.assert_allclose(stepped(model), stepped(own), rtol=1e-3, atol=1e-6)  # MJCF has 6 digits
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["robot.xml", "work"]


@pytest.mark.parametrize("robot", builtin_robots())
def test_a_binary_model_is_bit_identical(robot, tmp_path):
    out = tmp_path / "robot.mjb"
    assert main(["export", "--robot", robot, "--out", str(out)]) == 0
    model = mujoco.MjModel.from_binary_path(str(out))
    own = spec_with_home(load_robot(robot), ModelOptions()).compile()
    assert physics_fingerprint(model) == physics_fingerprint(own)
    np.testing.assert_array_equal(stepped(model), stepped(own))


def test_options_leave_out_elasticity_and_friction(tmp_path):
    out = str(tmp_path / "rigid.mjb")
    assert main(["export", "--out", out, "--no-flexible", "--no-friction"]) == 0
    model = mujoco.MjModel.from_binary_path(out)
    assert (model.nv, model.nactuator) == (6, 6)


def test_it_says_what_it_wrote(tmp_path, capsys):
    assert main(["export", "--out", str(tmp_path / "a.xml")]) == 0
    assert "a.xml: 12 degrees of freedom, 18 controls" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--out", "robot.urdf"], "suffix is '.urdf', must be .xml or .mjb"),
        (["--out", "robot"], "suffix is ''"),
        (["--robot", "irb"], "Unknown robot 'irb'. Available: " + ", ".join(builtin_robots())),
        (["--robot", "absent.toml"], "Cannot read robot description absent.toml"),
        (["--out", "absent/robot.xml"], "absent/robot.xml: cannot be written"),
    ],
)
def test_a_request_that_cannot_be_met_is_one_line_and_exit_code_1(arguments, message, capsys, tmp_path):
    assert main(["export", *arguments]) == 1
    assert message in only_line_of_error(capsys)
    assert [p.name for p in tmp_path.rglob("*")] == ["work"]


def test_a_bad_description_is_one_line_too(tmp_path, capsys):
    path = tmp_path / "broken.toml"
    path.write_text("[robot]\nname = [\n")
    assert main(["export", "--robot", str(path)]) == 1
    assert "broken.toml is not valid TOML" in only_line_of_error(capsys)


def test_a_folder_in_the_way_is_not_replaced(tmp_path, capsys):
    (tmp_path / "taken.xml").mkdir()
    assert main(["export", "--out", str(tmp_path / "taken.xml")]) == 1
    assert "taken.xml" in only_line_of_error(capsys)
    assert (tmp_path / "taken.xml").is_dir()

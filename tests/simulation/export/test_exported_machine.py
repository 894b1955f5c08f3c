"""A machine as MJCF: effects that MuJoCo has are in it, the others are listed, and plain MuJoCo repeats the run."""

import json
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.effects import EFFECTS
from ffgym.robot import ModelOptions
from ffgym.simulation.export import export_model
from ffgym.simulation.plant import Machine, save_machine
from tests.simulation.export.test_exported_run import WITHOUT_FFGYM


@pytest.fixture(scope="module")
def machine(irb4600):
    effects = (
        EFFECTS["coulomb_level"].on(irb4600, "j1", change=0.2),
        EFFECTS["base_flexibility"].on(irb4600, compliance=[1e-7, 0.0, 0.0]),
        EFFECTS["load_friction"].on(irb4600, "j2", share=0.06),
        EFFECTS["tool_frame"].on(irb4600, offset=[1e-3, 0.0, 0.0]),
        EFFECTS["cogging"].on(irb4600, amplitude=0.0),
    )
    return Machine(robot=irb4600, effects=effects)


@pytest.fixture
def file(machine, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return str(save_machine(machine, tmp_path / "cell.toml", title="a cell", source="a test"))


def test_the_model_has_what_mujoco_has_and_lists_the_rest(machine, irb4600, tmp_path):
    export_model(tmp_path / "out", machine)
    text = (tmp_path / "out" / "model.xml").read_text(encoding="utf-8")
    model = mujoco.MjModel.from_xml_string(text)
    inside = Machine(robot=irb4600, effects=machine.effects[:2])
    own = inside.spec(ModelOptions()).compile()
    for field in ("body_mass", "jnt_stiffness", "dof_damping", "actuator_biasprm", "actuator_dynprm"):
        np.testing.assert_array_equal(getattr(model, field), getattr(own, field))
    assert model.joint("base_x").id >= 0
    for told in (text, (tmp_path / "out" / "README.txt").read_text(encoding="utf-8")):
        assert "Not in it, as MuJoCo has no such effects: load_friction (share = [0.0, 0.06," in told
        assert "tool_frame" in told
        assert "cogging" not in told  # there is none of it


def test_a_robot_has_no_such_list(irb4600, tmp_path):
    export_model(tmp_path / "out", irb4600)
    assert "Not in it" not in (tmp_path / "out" / "README.txt").read_text(encoding="utf-8")


def test_plain_mujoco_repeats_the_motion_of_what_is_in_the_model(file, tmp_path, capsys):
    (tmp_path / "swing.csv").write_text(swing_table(), encoding="utf-8")
    assert main(["export", file, "swing.csv", "--feedforward", f"model:{file}", "--json", "origin.json"]) == 0
    assert "note: Not in it" in capsys.readouterr().out
    assert json.loads((tmp_path / "origin.json").read_text())["feedforward_law"] == "model:cell"
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_FFGYM], cwd=tmp_path / "export", capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


def swing_table():
    """Joint positions of a small smooth swing, every 4 ms."""
    t = 0.004 * np.arange(76)
    swing = 0.01 * (1 - np.cos(2 * np.pi * t / t[-1])) ** 2
    rows = np.column_stack([t, np.array([0.0, 0.4, 0.2, 0.0, 0.5, 0.0]) + swing[:, None]])
    head = ",".join(["t_s", *(f"j{k}_rad" for k in range(1, 7))])
    return "\n".join([head, *(",".join(f"{value:.9f}" for value in row) for row in rows)])

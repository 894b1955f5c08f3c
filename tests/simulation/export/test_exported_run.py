"""An exported folder repeats the recording in plain MuJoCo, without ffgym."""

import subprocess
import sys
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from ffgym.agents.lugre import dynamic_lugre, static_lugre
from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.recordings import read_recording
from ffgym.robot import ModelOptions, builtin_robots, load_robot, physics_fingerprint
from ffgym.simulation import Run, simulate
from ffgym.simulation.export import ReferenceForm, export_model, export_run
from ffgym.simulation.plant import Plant
from ffgym.studies import circle_references
from tests.robot.robot_samples import unusual

WITHOUT_FFGYM = (
    "import runpy, sys; sys.modules.update(ffgym=None, scipy=None, gymnasium=None); "
    "runpy.run_path('play.py', run_name='__main__')"
)
"""Play in a process where neither ffgym nor what it needs beside numpy and mujoco can be imported."""


def swing(robot):
    """Sine of all joints about the home pose, or mid-range; it starts at full speed."""
    low, high = robot.kinematics.range.T
    centre = (low + high) / 2 if robot.work_area is None else robot.work_area.home
    amplitude = np.minimum(0.05, 0.05 * (high - low))
    path = joint_sine(amplitude, 1.0, 0.2, centre=centre, dt=robot.servo.control_dt, name="swing")
    return joint_reference(robot, path)


SHARES = (0.6, 1.0)


def shared(robot, share):
    """The robot with a share of the friction of joints 2 and 3 behind the elasticity."""
    return robot.with_arm_share([0, share, share, 0, 0, 0])


@pytest.fixture(scope="module")
def circle(irb4600, arm):
    (reference,) = circle_references(arm, ["p2"], [0.1], radii=[0.01]).values()
    return Run(reference=reference, law=dynamic_lugre(irb4600))


@pytest.fixture(scope="module")
def runs(irb4600, circle):
    """Runs and options by name: robots, tool and joint motions, laws, and parts left out."""
    rails = unusual(irb4600)
    swings = {name: swing(load_robot(name)) for name in builtin_robots()}
    return {
        "circle": (circle, ModelOptions()),
        **{
            name: (Run(reference=motion, law=static_lugre(motion.robot)), ModelOptions())
            for name, motion in swings.items()
        },
        "rails, coupled wrist and springs": (Run(reference=swing(rails), law=dynamic_lugre(rails)), ModelOptions()),
        **{
            f"arm friction, share {share}": (Run(reference=swing(shared(irb4600, share))), ModelOptions())
            for share in SHARES
        },
        "rigid": (Run(reference=swing(irb4600)), ModelOptions(flexible=False)),
        "no friction, no gravity": (Run(reference=swing(irb4600)), ModelOptions(friction=False, gravity=False)),
        "other step": (Run(reference=swing(irb4600)), ModelOptions(physics_dt=0.0005)),
    }


NAMES = (
    "circle",
    *builtin_robots(),
    "rails, coupled wrist and springs",
    *(f"arm friction, share {share}" for share in SHARES),
    "rigid",
    "no friction, no gravity",
    "other step",
)


def table(path):
    """Names and numbers, shape (rows, columns), of a CSV file."""
    with path.open() as file:
        names = file.readline().strip().split(",")
        return names, np.loadtxt(file, delimiter=",", ndmin=2)


@pytest.mark.parametrize("name", NAMES)
def test_the_player_repeats_the_recording_without_ffgym(name, runs, tmp_path):
    run, options = runs[name]
    export_run(tmp_path / "out", run, options=options)
    played = subprocess.run(
        [sys.executable, "-c", WITHOUT_FFGYM], cwd=tmp_path / "out", capture_output=True, text=True, check=False
    )
    assert played.returncode == 0, played.stdout + played.stderr
    assert played.stderr == ""
    lines = played.stdout.splitlines()
    assert lines[0] == "largest difference, SI units"
    named = {line.split()[0]: float(line.split()[1]) for line in lines[1:-1]}
    assert {"motor.position", "motor.velocity", "motor.effort", "feedback.integral", "link.position"} <= named.keys()
    assert ("tcp.position" in named) == (run.reference.robot.tool is not None)
    assert ("friction.effort" in named) == options.friction
    assert ("arm_friction.effort" in named) == bool(run.reference.robot.arm_share.any())
    assert max(named.values()) < 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_plain_mujoco_goes_through_the_states_of_the_recording_bit_for_bit(name, runs, tmp_path):
    """Joint by joint from `qpos`, `qvel` and `act`, beside the player; also the state at the start."""
    run, options = runs[name]
    recording = export_run(tmp_path / "out", run, options=options)
    robot = run.reference.robot
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "model.xml"))
    _, controls = table(tmp_path / "out" / "controls.csv")
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    stride = round(recording.dt / model.opt.timestep)
    assert len(controls) == (len(recording) - 1) * stride + 1
    states = []
    for k, row in enumerate(controls):
        if k % stride == 0:
            states.append([data.qpos.copy(), data.qvel.copy(), data.act.copy()])
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
    qpos, qvel, act = (np.stack(part) for part in zip(*states, strict=True))
    state = Plant(robot, 1, options=replace(options, looks=False)).unpack(qpos, qvel, act)
    np.testing.assert_array_equal(state.motor_position, recording.joint_array("motor.position"))
    np.testing.assert_array_equal(state.motor_velocity, recording.joint_array("motor.velocity"))
    np.testing.assert_array_equal(state.link_position, recording.joint_array("link.position"))
    np.testing.assert_array_equal(state.link_velocity, recording.joint_array("link.velocity"))
    u_i = state.integral * robot.servo.integral_gain
    np.testing.assert_array_equal(u_i, recording.joint_array("feedback.integral"))
    assert not any(int(warning.number) for warning in data.warning)


def test_the_folder_holds_the_recording_of_the_simulation(circle, tmp_path):
    recording = export_run(tmp_path / "out", circle)
    (own,) = simulate([circle])
    assert recording.equals(own)
    assert read_recording(tmp_path / "out" / "recording.csv").equals(own)
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["README.txt", "controls.csv", "model.xml", "play.py", "recording.csv", "reference.csv"]
    text = (tmp_path / "out" / "README.txt").read_text()
    assert circle.reference.name in text
    assert "lugre_dynamic" in text
    assert [name for name in names if name not in text] == ["README.txt"]


def test_the_model_without_its_keyframes_is_the_simulated_one(circle, irb4600, tmp_path):
    recording = export_run(tmp_path / "out", circle, binary=True)
    spec = mujoco.MjSpec.from_file(str(tmp_path / "out" / "model.xml"))
    names = [key.name for key in spec.keys]
    assert names == ["home", "start"]
    compiled = spec.compile()
    binary = mujoco.MjModel.from_binary_path(str(tmp_path / "out" / "model.mjb"))
    assert physics_fingerprint(binary) == physics_fingerprint(compiled)
    for element in (*spec.keys, *spec.geoms, *spec.lights, *spec.textures):
        spec.delete(element)
    spec.visual.headlight = mujoco.MjSpec().visual.headlight
    spec.visual.map.znear = mujoco.MjSpec().visual.map.znear
    assert physics_fingerprint(spec.compile()) == recording.header.provenance["physics_fingerprint"]


def test_both_keyframes_rest_in_equilibrium(circle, irb4600, tmp_path):
    export_run(tmp_path / "out", circle)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "model.xml"))
    data = mujoco.MjData(model)
    for name in ("home", "start"):
        mujoco.mj_resetDataKeyframe(model, data, model.key(name).id)
        before = data.qpos.copy()
        mujoco.mj_step(model, data, 400)
        np.testing.assert_allclose(data.qpos, before, rtol=0, atol=1e-12)


def test_controls_have_their_names_and_the_reference_at_control_steps(circle, tmp_path):
    recording = export_run(tmp_path / "out", circle)
    names, controls = table(tmp_path / "out" / "controls.csv")
    assert names[:4] == [
        "motor.position.j1 [rad]",
        "motor.velocity.j1 [rad/s]",
        "motor.torque.j1 [N m]",
        "motor.position.j2 [rad]",
    ]
    np.testing.assert_array_equal(controls[::16, 0::3], circle.reference.motor_q)
    np.testing.assert_array_equal(controls[::16, 1::3], circle.reference.motor_dq)
    sums = recording.joint_array("feedforward.effort") + recording.joint_array("compensation.effort")
    np.testing.assert_array_equal(controls[::16, 2::3], sums[::4])


def test_the_reference_is_written_in_the_form_that_is_asked_for(circle, tmp_path):
    export_run(tmp_path / "out", circle, form=ReferenceForm(sides="motor", angles="deg"))
    names, values = table(tmp_path / "out" / "reference.csv")
    assert names[:2] == ["t [s]", "motor.position.j1 [deg]"]
    np.testing.assert_array_equal(values[:, 0], circle.reference.t)
    np.testing.assert_array_equal(values[:, 1:7], circle.reference.motor_q * (180 / np.pi))


def test_a_robot_alone_is_exported_in_its_home_pose(irb4600, one_axis, tmp_path):
    for robot in (irb4600, one_axis):
        folder = tmp_path / robot.name
        export_model(folder, robot, options=ModelOptions(friction=False))
        assert sorted(path.name for path in folder.iterdir()) == ["README.txt", "model.xml"]
        model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
        assert (model.nkey, model.nactuator) == (1, robot.n_joints)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
        mujoco.mj_step(model, data, 400)
        np.testing.assert_allclose(data.qpos, model.key("home").qpos, rtol=0, atol=1e-12)


def test_home_stays_within_the_limits_of_a_robot_without_a_work_area(one_axis, tmp_path):
    away = replace(one_axis, kinematics=replace(one_axis.kinematics, range=np.array([[0.5, 2.0]])))
    export_model(tmp_path / "out", away)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "model.xml"))
    assert model.key("home").qpos == [0.5]


def test_progress_counts_simulating_and_writing_up_to_its_total(circle, tmp_path):
    seen = []
    export_run(tmp_path / "out", circle, progress=lambda done, total: seen.append((done, total)))
    done, totals = zip(*seen, strict=True)
    assert set(totals) == {2 * circle.reference.duration}
    assert list(done) == sorted(done)
    assert done[-1] == pytest.approx(totals[-1])


@pytest.mark.parametrize("when", ["simulating", "writing"])
def test_an_interrupted_export_leaves_nothing(when, circle, tmp_path):
    def interrupt(done, total):
        if (done > total / 2) == (when == "writing"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        export_run(tmp_path / "out", circle, progress=interrupt)
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_cannot_be_simulated_leaves_nothing(circle, tmp_path):
    with pytest.raises(FFGymError, match=r"record_dt = 0\.003 s must be"):
        export_run(tmp_path / "out", circle, record_dt=0.003)
    assert list(tmp_path.iterdir()) == []


def test_a_player_whose_files_do_not_match_says_so(runs, tmp_path):
    run, options = runs["one_axis"]
    export_run(tmp_path / "out", run, options=options)
    export_run(tmp_path / "other", replace(run, law=NoCompensation()), options=options)
    (tmp_path / "other" / "recording.csv").replace(tmp_path / "out" / "recording.csv")
    command = [sys.executable, str(tmp_path / "out" / "play.py")]
    played = subprocess.run(command, capture_output=True, text=True, check=False)
    assert played.returncode == 1
    assert float(played.stdout.split()[-1]) > 1e-6


@pytest.mark.parametrize("name", ["controls.csv", "recording.csv"])
def test_a_player_whose_files_are_cut_off_says_so(name, runs, tmp_path):
    run, options = runs["one_axis"]
    export_run(tmp_path, run, options=options)
    lines = (tmp_path / name).read_text(encoding="utf-8").splitlines()
    (tmp_path / name).write_text("\n".join(lines[: -len(lines) // 3]), encoding="utf-8")
    command = [sys.executable, str(tmp_path / "play.py")]
    played = subprocess.run(command, capture_output=True, text=True, check=False)
    assert played.returncode == 1
    assert "a file is cut off" in played.stdout
    assert played.stderr == ""

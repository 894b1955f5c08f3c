"""FMUs are valid, run in FMPy, and give what the simulation gives; others are not written."""

import ctypes
import platform
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.agents.lugre import dynamic_lugre
from ffgym.control import NoCompensation, Setpoints, rigid_feedforward
from ffgym.core.errors import FFGymError
from ffgym.deployment import write_fmus
from ffgym.deployment.code import fmu, fmu_build
from ffgym.deployment.code.compiler import find_compiler
from ffgym.deployment.code.fmu_check import TOLERANCE, FmuCheck, Slave
from ffgym.paths.motions import load_motion
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation.export.model import control_blocks, plant_of
from ffgym.simulation.plant import Machine, load_machine

pytest.importorskip("fmpy")
pytestmark = [
    pytest.mark.skipif(find_compiler() is None, reason="no C compiler"),
    pytest.mark.skipif(platform.machine() != "x86_64" or platform.system() != "Linux", reason="another platform"),
]


def short(robot, motion, samples):
    whole = load_motion(RigidArm(robot), motion).reference
    return replace(whole, **{name: getattr(whole, name)[:samples] for name in ("t", "q", "dq", "ddq")}, phases=())


@pytest.fixture(scope="module")
def robot():
    return load_robot("one_axis")


@pytest.fixture(scope="module")
def reference(robot):
    return short(robot, "sine", 300)


@pytest.fixture(scope="module")
def written(robot, reference, tmp_path_factory):
    """Folder with FMUs of both versions, and their comparison."""
    folder = tmp_path_factory.mktemp("fmus") / "fmu"
    return folder, write_fmus(folder, dynamic_lugre(robot), reference)


def test_plant_and_program_agree_with_the_simulation_in_both_versions(written, reference):
    folder, checks = written
    assert [check.version for check in checks] == ["2.0", "3.0"]
    for check in checks:
        assert check.steps == len(reference.t) - 1
        assert check.largest_difference <= TOLERANCE
        compared = {"motor_position", "motor_velocity", "link_position", "link_velocity", "torque", "added_torque"}
        assert compared <= set(check.differences)
    names = {f"{name}_fmi{version}.fmu" for name in ("plant", "program") for version in "23"} | {"README.txt"}
    assert {path.name for path in folder.iterdir()} == names


def test_fmpy_simulates_the_program_into_the_plant(written, reference):
    from fmpy import simulate_fmu

    folder, _ = written
    dt, stop = reference.robot.servo.control_dt, reference.t[-2]
    for version in "23":
        options = {"output_interval": dt, "stop_time": stop}
        setpoints = simulate_fmu(str(folder / f"program_fmi{version}.fmu"), **options)
        inputs = setpoints[[name for name in setpoints.dtype.names if not name.startswith("added")]]
        found = simulate_fmu(str(folder / f"plant_fmi{version}.fmu"), input=inputs, **options)
        joint = reference.robot.joints[0]
        assert np.abs(setpoints[f"position.{joint}"] - reference.motor_q[1:, 0]).max() < 1e-12
        moved = found[f"motor_position.{joint}"]
        assert np.ptp(moved) > 0.5 * np.ptp(reference.motor_q)
        assert np.abs(moved - reference.motor_q[:-1, 0]).max() < 0.05 * np.ptp(reference.motor_q)


def test_a_plant_takes_steps_of_any_multiple_of_the_physics_step(written, robot, reference):
    folder, _ = written
    plant, dt = plant_of(Machine.of(robot), None), robot.servo.control_dt
    torque = rigid_feedforward(RigidArm(robot), reference)
    setpoints = Setpoints(
        position=reference.motor_q[None], velocity=reference.motor_dq[None], torque=torque[None], dt=dt
    )
    rows = np.concatenate([*control_blocks(plant, setpoints, lambda done, total: None)])
    ends = {}
    for each in (1, plant.n_substeps):  # physics steps in one step of the co-simulation
        with Slave(folder / "plant_fmi3.fmu") as slave:
            for k in range(each, 100 * plant.n_substeps + 1, each):
                for name, values in zip(("position", "velocity", "torque"), plant.split_controls(rows[k]), strict=True):
                    slave.set(name, values)
                slave.step((k - each) * plant.physics_dt, each * plant.physics_dt)
            ends[each] = slave.get("motor_position")
    assert np.abs(ends[1] - ends[plant.n_substeps]).max() < 1e-12


def test_other_steps_and_variables_are_refused_with_a_message(written, capfd):
    folder, _ = written
    for version in "23":
        for name, what in (("plant", "physics step"), ("program", "control step")):
            with Slave(folder / f"{name}_fmi{version}.fmu") as slave:
                with pytest.raises(Exception, match=r"doStep|DoStep"):
                    slave.step(0.0, 1.7e-4)
                assert f"no multiple of the {what}" in "".join(capfd.readouterr())


def test_a_reset_begins_the_motion_again(written):
    folder, _ = written
    for version in "23":
        with Slave(folder / f"program_fmi{version}.fmu") as slave:
            first = slave.get("position")
            for k in range(50):
                slave.step(0.004 * k, 0.004)
            assert not np.array_equal(slave.get("position"), first)
            slave._fmu.reset()
            assert np.array_equal(slave.get("position"), first)
        with Slave(folder / f"plant_fmi{version}.fmu") as slave:
            first, rest = slave.get("position"), slave.get("motor_position")
            slave.set("position", first + 0.1)
            slave.step(0.0, 0.004)
            assert not np.array_equal(slave.get("motor_position"), rest)
            slave._fmu.reset()
            assert np.array_equal(slave.get("position"), first)
            assert np.array_equal(slave.get("motor_position"), rest)


def test_a_setpoint_that_mujoco_drops_is_an_error_until_the_plant_is_reset(written, tmp_path, monkeypatch, capfd):
    folder, _ = written
    monkeypatch.chdir(tmp_path)  # where MuJoCo writes its warning
    for version, wrong in (("2", 1e15), ("3", np.nan)):
        with Slave(folder / f"plant_fmi{version}.fmu") as slave:
            first, rest = slave.get("position"), slave.get("motor_position")
            slave.set("torque", first + wrong)
            with pytest.raises(Exception, match=r"doStep|DoStep"):
                slave.step(0.0, 0.004)
            assert "the simulation became unstable" in "".join(capfd.readouterr())
            slave._fmu.reset()
            assert np.array_equal(slave.get("motor_position"), rest)
            slave.step(0.0, 0.004)


def test_a_difference_that_is_no_number_is_the_largest():
    check = FmuCheck(version="3.0", steps=1, differences={"torque": 1e-12, "tcp": np.nan})
    assert np.isnan(check.largest_difference)


def test_outputs_cannot_be_set_and_unknown_variables_neither_read(written, capfd):
    folder, _ = written
    for version in "23":
        with Slave(folder / f"plant_fmi{version}.fmu") as slave:
            with pytest.raises(Exception, match=r"Real|Float64"):
                slave.set("motor_position", np.ones(1))
            assert "is no input" in "".join(capfd.readouterr())
            with pytest.raises(Exception, match=r"Real|Float64"):
                (slave._fmu.getReal if version == "2" else slave._fmu.getFloat64)([99])
            assert "there is no variable 99" in "".join(capfd.readouterr())


def test_a_plant_finds_its_model_in_a_folder_with_strange_signs(written, tmp_path):
    import fmpy
    from fmpy.simulation import instantiate_fmu

    folder, _ = written
    place = tmp_path / "a b%25 ü"
    fmpy.extract(str(folder / "plant_fmi2.fmu"), unzipdir=str(place))
    plant = instantiate_fmu(str(place), fmpy.read_model_description(str(place)), "CoSimulation")
    plant.freeInstance()


def test_time_begins_where_the_importer_says(written):
    folder, _ = written
    with Slave(folder / "program_fmi3.fmu") as slave:
        slave._fmu.reset()
        slave._fmu.enterInitializationMode(startTime=2.5)
        slave._fmu.exitInitializationMode()
        assert slave.get("time") == [2.5]
        slave.step(2.5, 0.004)
        assert slave.get("time") == [2.504]
        state = slave._fmu.getFMUState()
        slave.step(2.504, 0.004)
        slave._fmu.setFMUState(state)
        assert slave.get("time") == [2.504]
        slave._fmu.freeFMUState(state)
    with Slave(folder / "program_fmi2.fmu") as slave:
        slave._fmu.reset()
        slave._fmu.setupExperiment(startTime=2.5)
        time = ctypes.c_double()
        slave._fmu.dll.fmi2GetRealStatus(ctypes.c_void_p(slave._fmu.component), 2, ctypes.byref(time))
        assert time.value == 2.5


def test_a_state_that_is_set_again_repeats_the_steps_after_it_bit_for_bit(written):
    folder, _ = written
    for version in "23":
        for name, quantity in (("plant", "motor_position"), ("program", "torque")):
            with Slave(folder / f"{name}_fmi{version}.fmu") as slave:
                fmu = slave._fmu
                get, put, free = (
                    getattr(fmu, f"{verb}FMU{'s' if version == '2' else 'S'}tate") for verb in ("get", "set", "free")
                )

                def run(slave=slave, name=name, quantity=quantity):
                    if name == "plant":
                        slave.set("position", slave.get("motor_position") + 0.05)
                    found = []
                    for k in range(40):
                        slave.step(0.004 * k, 0.004)
                        found.append(slave.get(quantity))
                    return np.array(found)

                run()
                state = get()
                first = run()
                assert not np.array_equal(run(), first)
                put(state)
                assert np.array_equal(run(), first)
                free(state)


def test_an_archive_has_what_the_standard_asks_for_and_needs_nothing_else(written):
    folder, _ = written
    for version, place in (("2", "linux64"), ("3", "x86_64-linux")):
        names = zipfile.ZipFile(folder / f"plant_fmi{version}.fmu").namelist()
        assert {"modelDescription.xml", f"binaries/{place}/plant.so", "resources/model.mjb"} < set(names)
        assert sum(name.startswith(f"binaries/{place}/libmujoco.so") for name in names) == 1
        assert "documentation/licenses/mujoco_LICENSE" in names


def test_a_binary_shows_functions_of_the_standard_alone(written, tmp_path):
    folder, _ = written
    for version, place in (("2", "linux64"), ("3", "x86_64-linux")):
        file = zipfile.ZipFile(folder / f"program_fmi{version}.fmu").extract(f"binaries/{place}/program.so", tmp_path)
        library = ctypes.CDLL(file)
        assert hasattr(library, f"fmi{version}DoStep")
        assert hasattr(library, f"fmi{version}SetDebugLogging")
        assert not any(hasattr(library, name) for name in ("fmu_step", "law_step"))


def test_fmus_that_differ_or_are_invalid_are_not_written(robot, reference, tmp_path, monkeypatch):
    fill = fmu.fill_template

    def changed(template, known):
        return fill(template, known).replace("(cube * x + square) * x", "(cube * x + square) * x * 1.001")

    monkeypatch.setattr(fmu, "fill_template", changed)
    with pytest.raises(FFGymError, match=r"of the FMU \(FMI 2.0\) differs from the simulation by"):
        write_fmus(tmp_path / "fmu", dynamic_lugre(robot), reference, versions=["2.0"])
    monkeypatch.setattr(fmu, "fill_template", fill)
    text = fmu_build.description_text
    monkeypatch.setattr(fmu_build, "description_text", lambda *given: text(*given).replace(b'"rad/s"', b'"rad/x"', 1))
    with pytest.raises(FFGymError, match="FMPy finds"):
        write_fmus(tmp_path / "fmu", dynamic_lugre(robot), reference, versions=["2.0"])
    assert not [*tmp_path.iterdir()]


def test_a_law_without_c_has_a_plant_alone(robot, reference, tmp_path):
    with pytest.raises(FFGymError, match="'none' does not run sample by sample"):
        write_fmus(tmp_path / "fmu", NoCompensation(), reference)
    (check,) = write_fmus(tmp_path / "fmu", NoCompensation(), reference, versions=["3.0"], program=False)
    assert check.largest_difference <= TOLERANCE
    assert {path.name for path in (tmp_path / "fmu").iterdir()} == {"plant_fmi3.fmu", "README.txt"}


@pytest.mark.slow
def test_six_axes_with_backlash_leave_it_out_and_say_so(tmp_path):
    machine = load_machine(Path(__file__).parents[3] / "docs" / "backlash.toml")
    checks = write_fmus(
        tmp_path / "fmu", NoCompensation(), short(machine.robot, "circles", 400), machine=machine, program=False
    )
    assert all(check.largest_difference <= TOLERANCE and "tcp" in check.differences for check in checks)
    assert "Not in it, as MuJoCo has no such effects: backlash" in (tmp_path / "fmu" / "README.txt").read_text()


@pytest.mark.parametrize(
    ("name", "change", "reason"),
    [
        ("platform.system", lambda: "Darwin", "Linux with x86-64 alone"),
        ("is_installed", lambda name: False, r"pip install 'ffgym\[fmu\]'"),
    ],
)
def test_what_is_missing_is_told(name, change, reason, robot, reference, tmp_path, monkeypatch):
    monkeypatch.setattr(f"ffgym.deployment.code.fmu.{name}", change)
    with pytest.raises(FFGymError, match=reason):
        write_fmus(tmp_path / "fmu", dynamic_lugre(robot), reference)
    with pytest.raises(FFGymError, match="version of FMI"):
        write_fmus(tmp_path / "fmu", dynamic_lugre(robot), reference, versions=["1.0"])

"""`ffgym stream` and `ffgym emulate`, against each other and with bad input."""

import json
import socket
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.deployment import SetpointPlan, write_plan
from ffgym.recordings import read_recording
from ffgym.robot import load_robot


@pytest.fixture(scope="module")
def plan() -> SetpointPlan:
    """One second of a joint, and a correction."""
    t = np.arange(251) * 0.004
    wave = np.sin(np.pi * t)[:, None] ** 2
    return SetpointPlan(
        name="swing",
        robot="one_axis",
        law="made up",
        joints=("j1",),
        units=("rad",),
        dt=0.004,
        program=0.05 * wave,
        correction=1e-3 * wave,
        torque=0 * wave,
    )


@pytest.fixture
def plan_file(plan: SetpointPlan, tmp_path: Path) -> Path:
    write_plan(plan, tmp_path / "plan.npz")
    return tmp_path / "plan.npz"


def free_port(kind: int = socket.SOCK_DGRAM) -> int:
    """Return a port that nobody has."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def of_six_axes(plan: SetpointPlan) -> SetpointPlan:
    """Return a plan in which the first axis of the six-axis robot swings as that of another plan."""
    robot = load_robot("irb4600_60_205")

    def first(part: np.ndarray) -> np.ndarray:
        return np.pad(part, ((0, 0), (0, 5)))

    return replace(
        plan,
        robot=robot.name,
        joints=robot.joints,
        units=robot.kinematics.units,
        program=first(plan.program) + np.asarray(robot.work_area.home),
        correction=first(plan.correction),
        torque=first(plan.torque),
    )


def error_of(capsys: pytest.CaptureFixture[str]) -> str:
    return capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize(
    "protocol", ["egm", pytest.param("rsi", marks=pytest.mark.slow), pytest.param("rtde", marks=pytest.mark.slow)]
)
def test_a_plan_goes_to_an_emulated_controller_in_another_process(
    protocol: str, plan: SetpointPlan, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    address = f"127.0.0.1:{free_port()}"
    if protocol == "rtde":
        plan = of_six_axes(plan)
    plan_file = tmp_path / "plan.npz"
    write_plan(plan, plan_file)
    common = ["--address", address, "--json"]
    options = [
        "--robot",
        plan.robot,
        "--delay-ms",
        "9.3",
        "--cutoff-hz",
        "20",
        "--longest-s",
        "60",
        "--plan",
        str(plan_file),
        *common,
    ]
    outputs = [str(tmp_path / "emulator.json"), "--out", str(tmp_path / "truth.npz")]
    command = [sys.executable, "-m", "ffgym", "emulate", protocol, *options, *outputs]
    emulator = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    begun = emulator.stdout.readline()
    time.sleep(0.5)  # it has said that it will listen
    arguments = [str(plan_file), "--protocol", protocol, *common, str(tmp_path / "stream.json")]
    assert main(["stream", *arguments, "--out", str(tmp_path / "log.npz")]) == 0
    said, _ = emulator.communicate(timeout=60)
    # both sides say what they did
    assert "delay 9.30 ms, first-order filter at 20.0 Hz" in begun
    assert "a stream came" in said
    assert "ended: " in capsys.readouterr().out
    told = json.loads((tmp_path / "stream.json").read_text())
    assert told["state"] == "ended"
    assert told["sent"] > 100
    assert told["versions"]["ffgym"]
    emulated = json.loads((tmp_path / "emulator.json").read_text())
    assert emulated["physics_fingerprint"]
    # the robot moved as it was told to
    log, truth = (read_recording(tmp_path / name) for name in ("log.npz", "truth.npz"))
    moved = truth["reference.position.j1"] / truth.header.gear_ratio[0]
    assert (
        0.5 < np.abs(moved).max() / np.abs(plan.setpoints[:, 0]).max() < 1.01
    )  # less if this machine paused at the turn
    assert log.header.meta["law"] == "made up"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--largest-mrad", "0"], "--largest-mrad = 0.0 mrad is out of range"),
        (["--largest-mrad", "1e-308"], "--largest-mrad = 1e-308 mrad is out of range"),
        (["--largest-rate-mrad-s", "1e308"], "--largest-rate-mrad-s = 1e+308 mrad/s is out of range"),
        (["--largest-acceleration-rad-s2", "1e308"], "--largest-acceleration-rad-s2 = 1e+308 rad/s^2 is out of range"),
        (["--patience-ms", "25"], "patience + ramp = 35 ms"),
        (
            ["--protocol", "rsi", "--patience-ms", "3"],
            "patience = 3 ms must be longer than the controller's cycle of 4 ms",
        ),
        (["--robot", "irb4600_60_205"], "is for joints j1 of 'one_axis', robot 'irb4600_60_205' has j1, j2"),
        (["--address", "127.0.0.1:0"], "port of '127.0.0.1:0' = 0"),
        (["--address", "192.0.2.1:6510"], "Cannot listen at 192.0.2.1:6510"),
        (["--address", ".."], "There is no host '..'"),
        (["--protocol", "rtde"], "RTDE is for robots of 6 hinges"),
        (["--out", "log.txt"], "Unknown recording format '.txt'"),
    ],
)
def test_a_stream_that_cannot_be_is_one_line_and_writes_nothing(
    arguments: list[str], message: str, plan_file: Path, capsys, monkeypatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["stream", str(plan_file), "--wait-s", "0.1", *arguments]) == 1
    assert message in error_of(capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["plan.npz"]


@pytest.mark.parametrize("command", [["stream"], ["export", "program"]])
def test_a_plan_of_an_own_robot_asks_for_its_description(command, plan, capsys, tmp_path: Path) -> None:
    write_plan(replace(plan, robot="mine"), tmp_path / "plan.npz")
    assert main([*command, str(tmp_path / "plan.npz"), "--out", str(tmp_path / "new.npz")]) == 1
    assert "is of robot 'mine', which is not built in. Name its description: --robot FILE." in error_of(capsys)


def test_a_controller_that_never_speaks_is_one_line(plan_file: Path, capsys, tmp_path: Path) -> None:
    address = f"127.0.0.1:{free_port()}"
    assert main(["stream", str(plan_file), "--address", address, "--wait-s", "0.1"]) == 1
    assert "No packet came within 0.1 s. Check the address" in error_of(capsys)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--delay-ms", "2"], "delay = 2 ms must be at least the cycle of 4 ms"),
        (["--delay-ms", "9300"], "delay of set-points = 9.3 s is out of range"),
        (["--damping", "0.7"], "--damping has no effect without --cutoff-hz"),
        (["--address", ".."], "There is no host '..'"),
        (["--drop", "2"], "share of packets: drop = 2.0"),
        (["--robot", "nobody"], "nobody"),
        (["--robot", "irb4600_60_205", "--plan", "plan.npz"], "is for joints j1"),
    ],
)
def test_an_emulator_that_cannot_be_is_one_line(arguments, message, plan_file, capsys, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["emulate", "egm", "--robot", "one_axis", *arguments]) == 1
    assert message in error_of(capsys)


def test_an_emulator_that_runs_a_program_needs_one(capsys) -> None:
    assert main(["emulate", "rsi", "--robot", "one_axis"]) == 1
    assert "the controller runs the program itself; name its plan: --plan" in error_of(capsys)


def test_an_emulator_without_a_stream_ends_and_says_so(capsys, plan: SetpointPlan, tmp_path: Path) -> None:
    write_plan(replace(plan, program=plan.program + 0.3), tmp_path / "plan.npz")
    options = ["--robot", "one_axis", "--plan", str(tmp_path / "plan.npz"), "--longest-s", "0.1"]
    assert main(["emulate", "egm", *options, "--address", f"127.0.0.1:{free_port()}"]) == 0
    assert "no stream came" in capsys.readouterr().out


def test_an_emulator_on_a_busy_computer_says_so(plan_file: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("ffgym.cli.emulate.serve_live", lambda *args, **options: 7)  # cycles that began late
    address = f"127.0.0.1:{free_port()}"
    command = ["emulate", "egm", "--robot", "one_axis", "--plan", str(plan_file), "--address", address]
    assert main(command) == 0
    assert "this computer is too busy to keep the controller's time" in capsys.readouterr().out


def test_a_plan_is_streamed_to_the_emulator_in_lock_step(plan_file: Path, tmp_path: Path, capsys) -> None:
    command = ["emulate", "egm", "--robot", "one_axis", "--plan", str(plan_file), "--delay-ms", "8"]
    places = ["--log", str(tmp_path / "log.npz"), "--out", str(tmp_path / "truth.npz")]
    assert main([*command, *places, "--json", str(tmp_path / "told.json")]) == 0
    assert "ended: " in capsys.readouterr().out
    told = json.loads((tmp_path / "told.json").read_text())["stream"]
    assert told["state"] == "ended"
    assert told["largest_correction"] == [pytest.approx(1e-3, rel=1e-3)]
    log, truth = (read_recording(tmp_path / name) for name in ("log.npz", "truth.npz"))
    # 1 mrad behind the gearbox
    ratio = load_robot("one_axis").drive.gear_ratio[0]
    assert log.joint_array("correction.position").max() == pytest.approx(1e-3 * ratio, rel=1e-3)
    assert truth.t[-1] > 1.0


def test_an_emulator_with_other_feed_forward_than_planned_says_so(plan, tmp_path: Path, capsys) -> None:
    write_plan(replace(plan, meta={"feedforward": "none"}), tmp_path / "plan.npz")
    command = ["emulate", "egm", "--robot", "one_axis", "--plan", str(tmp_path / "plan.npz"), "--delay-ms", "8"]
    assert main([*command, "--log", str(tmp_path / "log.npz")]) == 0
    assert "the plan counts on rigid feed-forward from none" in capsys.readouterr().out
    assert main([*command, "--log", str(tmp_path / "log.npz"), "--feedforward", "none"]) == 0
    assert "the plan counts on" not in capsys.readouterr().out


def test_a_plan_has_its_own_time_to_be_emulated(plan_file: Path, tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("ffgym.cli.emulate._SPARE", -0.5)
    command = ["emulate", "egm", "--robot", "one_axis", "--plan", str(plan_file), "--delay-ms", "8"]
    assert main([*command, "--log", str(tmp_path / "log.npz")]) == 1
    assert "The session is running after 0.5 s" in error_of(capsys)
    assert not (tmp_path / "log.npz").exists()


def test_a_cycle_of_12_ms_has_an_envelope_of_its_own(plan_file: Path, tmp_path: Path, capsys) -> None:
    command = ["emulate", "rsi_12ms", "--robot", "one_axis", "--plan", str(plan_file), "--delay-ms", "15"]
    assert main([*command, "--log", str(tmp_path / "log.npz")]) == 0
    assert "ended: " in capsys.readouterr().out


def test_corrections_timed_for_another_protocol_are_refused(plan: SetpointPlan, tmp_path: Path, capsys) -> None:
    write_plan(replace(plan, meta={"sends": "positions"}), tmp_path / "plan.npz")
    command = ["emulate", "rsi", "--robot", "one_axis", "--plan", str(tmp_path / "plan.npz")]
    assert main([*command, "--log", str(tmp_path / "log.npz")]) == 1
    assert "Plan the motion again: ffgym plan --sends corrections" in error_of(capsys)
    # without a correction there is nothing that could come too late
    write_plan(replace(plan, correction=0 * plan.correction, meta={"sends": "positions"}), tmp_path / "plan.npz")
    assert main([*command, "--log", str(tmp_path / "log.npz")]) == 0


def test_a_lock_step_without_plan_is_refused(tmp_path: Path, capsys) -> None:
    assert main(["emulate", "egm", "--robot", "one_axis", "--log", str(tmp_path / "log.npz")]) == 1
    assert "there is no plan to stream. Name one: --plan." in capsys.readouterr().err


@pytest.mark.parametrize("option", [("--address", "nowhere"), ("--longest-s", "-1")])
def test_options_of_the_network_have_no_effect_in_lock_step(option: tuple[str, str], tmp_path: Path, capsys) -> None:
    command = ["emulate", "egm", "--robot", "one_axis", "--plan", "plan.npz", "--log", str(tmp_path / "log.npz")]
    assert main([*command, *option]) == 1
    assert f"{option[0]} has no effect with --log, which needs no network. Leave one of them out." in error_of(capsys)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["one_axis", "--out", "plan.txt"], "Unknown plan format '.txt'"),
        (["one_axis", "--feedforward", "none"], "feedforward has no effect without a motion"),
        (["one_axis", "--seconds", "0.1"], "duration = 0.1 s must be at least two ramps"),
        (["irb4600_60_205", "circles", "--seconds", "2"], "seconds has no effect on a motion"),
        (["irb4600_60_205", "circles", "--controller", "no.toml"], "no.toml"),
    ],
)
def test_a_plan_that_cannot_be_made_is_one_line(
    arguments: list, message: str, tmp_path: Path, monkeypatch, capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["plan", *arguments]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(tmp_path.glob("plan*"))


def test_a_controller_cannot_be_identified_from_nothing(tmp_path: Path, capsys) -> None:
    assert main(["identify", "controller", "--robot", "one_axis"]) == 1
    assert "No logs are given" in capsys.readouterr().err
    assert main(["identify", "controller", str(tmp_path / "no.npz"), "--robot", "one_axis"]) == 1
    assert "no such file" in capsys.readouterr().err

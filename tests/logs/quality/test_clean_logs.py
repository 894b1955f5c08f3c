"""Nothing is said against logs that are right; what is said of published recordings is true of them."""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.logs import read_logs
from ffgym.logs.quality import check_quality
from ffgym.paths.motions import list_motions, load_motion
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, builtin_robots, load_robot
from ffgym.simulation import Run, sensors_of, simulate
from ffgym.simulation.plant import Machine
from tests.logs.quality.quality_logs import clean_log, described

ENDS_AT_SPEED = "sine"
"""The sine of the thesis stops where it happens to be: that its log ends in motion is true."""

QUICK = [
    ("irb4600_60_205", "circles"),
    ("irb4600_60_205", "triangle"),
    ("kuka_kr300_r2500", "square"),
    ("two_link", "multisine"),
    ("one_axis", "sine"),
    ("ball_screw", "ladder"),
]


def objections(recording: Recording, robot) -> list[str]:
    report = check_quality(recording, robot)
    ends = recording.header.segment.startswith(ENDS_AT_SPEED)
    return [f.message for f in report.problems if not (ends and f.check == "ends_in_motion")]


@pytest.mark.parametrize(("robot", "motion"), QUICK)
@pytest.mark.parametrize("sensors", [True, False])
def test_nothing_is_said_against_a_clean_log(robot, motion, sensors):
    recording = clean_log(robot, motion, sensors=sensors)
    assert objections(recording, described(robot, motion)) == []
    assert objections(recording, None) == []


@pytest.mark.slow
@pytest.mark.parametrize("robot", builtin_robots())
@pytest.mark.parametrize("motion", list_motions())
@pytest.mark.parametrize("sensors", [True, False])
def test_nothing_is_said_against_any_shipped_motion_on_any_shipped_robot(robot, motion, sensors):
    try:
        recording = clean_log(robot, motion, sensors=sensors)
    except FFGymError as error:
        pytest.skip(str(error))
    assert objections(recording, described(robot, motion)) == []
    assert objections(recording, None) == []


@pytest.mark.parametrize("seed", range(3))
def test_a_machine_that_differs_from_its_description_is_no_fault_of_its_log(seed):
    """Friction 30 %, stiffness 30 %, masses 5 % and rotors 10 % off: what a diagnosis is there to find."""
    rng = np.random.default_rng(seed)
    nominal = described("irb4600_60_205", "multisine")

    def off(values, share):
        return values * np.exp(share * rng.uniform(-1, 1, size=np.shape(values)))

    coulomb = off(nominal.friction.coulomb, 0.3)
    friction = replace(
        nominal.friction, coulomb=coulomb, static=1.1 * coulomb, viscous=off(nominal.friction.viscous, 0.3)
    )
    drive = replace(
        nominal.drive,
        joint_stiffness=off(nominal.drive.joint_stiffness, 0.3),
        rotor_inertia=off(nominal.drive.rotor_inertia, 0.1),
    )
    factor = np.exp(0.05 * rng.uniform(-1, 1, size=nominal.n_joints))
    bodies = replace(
        nominal.bodies, mass=nominal.bodies.mass * factor, inertia=nominal.bodies.inertia * factor[:, None]
    )
    machine = replace(nominal, friction=friction, drive=drive, bodies=bodies)
    reference = load_motion(RigidArm(machine), "multisine").reference
    recording = simulate([Run(reference=reference)], sensors=sensors_of(machine), seed=seed)[0]
    assert objections(recording, nominal) == []


def test_a_payload_that_is_not_described_is_no_permutation():
    """With 60 kg more, the torque of the elbow is like what the shoulder needs; that of the shoulder is its own."""
    nominal = described("irb4600_60_205", "sine")
    machine = Machine(robot=nominal, effects=(EFFECTS["payload"].on(nominal, mass=60.0),))
    reference = load_motion(RigidArm(nominal), "sine").reference
    recording = simulate([Run(reference=reference)], machine=machine, sensors=sensors_of(nominal))[0]
    assert objections(recording, nominal) == []


def test_a_robot_on_the_ceiling_is_not_the_one_on_the_floor():
    nominal = described("irb4600_60_205", "multisine")
    hanging = replace(nominal, gravity=-nominal.gravity)
    recording = simulate([Run(reference=load_motion(RigidArm(hanging), "multisine").reference)])[0]
    report = check_quality(recording, nominal)
    assert report.verdict == "insufficient"
    assert report.problems[0].check == "gravity_direction"
    assert check_quality(recording, hanging).verdict == "good"


def test_a_log_of_another_robot_is_refused():
    report = check_quality(clean_log("irb4600_60_205", "circles"), load_robot("kuka_kr300_r2500"))
    assert report.verdict == "insufficient"
    assert {finding.check for finding in report.problems} == {"gear_ratio", "robot_name"}


def test_the_same_recording_gives_the_same_words():
    recording = clean_log("two_link", "multisine")
    robot = described("two_link", "multisine")
    texts = [json.dumps(check_quality(recording, robot).numbers(), allow_nan=False) for _ in range(2)]
    assert texts[0] == texts[1]


def test_checks_name_their_joint_whatever_it_is_called():
    recording = clean_log("two_link", "multisine")
    flat = recording.with_columns(**{"motor.effort.elbow": np.zeros(len(recording))})
    (finding,) = check_quality(flat).problems
    assert (finding.check, finding.joint, finding.columns) == ("constant", "elbow", ("motor.effort.elbow",))


TRUE_OF = {
    "emps": {"noise_burst"},  # the pulses that were injected on purpose
    "kuka_kr300_2020": {"scale", "lag"},  # coupled wrist, speed a row late
    "kuka_kr300_2021_10hz": {"rate_for_resonance"},  # 10 Hz beside 12 Hz
}


@pytest.mark.skipif(not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with published recordings")
@pytest.mark.parametrize("name", TRUE_OF)
def test_published_recordings_are_usable_and_what_is_flagged_is_true(name):
    files = sorted(Path(os.environ["FFGYM_DATA"], name).glob("*.npz"))
    assert files
    for file in files:
        for recording in read_logs(file, COLUMNS[name]):
            report = check_quality(recording, load_robot(recording.header.robot))
            assert report.verdict in ("good", "usable"), report.problems[0].message
            assert {finding.check for finding in report.problems} <= TRUE_OF[name]


COLUMNS = {"emps": "emps", "kuka_kr300_2020": "kuka_kr300_2020", "kuka_kr300_2021_10hz": "kuka_kr300_2021_10hz"}


@pytest.mark.parametrize(("rounding", "is_burst"), [(1e-13, False), (5e-12, False), (1e-6, True)])
def test_the_rounding_of_set_points_that_stand_still_is_no_burst_of_noise(rounding, is_burst):
    recording, rng = clean_log("irb4600_60_205", "circles", sensors=True), np.random.default_rng(0)
    still = 1.2 + 1e-15 * rng.normal(size=len(recording))
    still[400:600] += rounding * rng.normal(size=200)
    found = check_quality(recording.with_columns({"tcp_reference.position.z": still})).problems
    assert ("noise_burst" in {finding.check for finding in found}) == is_burst


def test_the_last_of_coarse_values_is_no_spike_for_being_as_far_off_as_noise_may_be():
    """A thermometer that reads in tenths, whose last reading is four of them below the one before."""
    log = clean_log("one_axis", "sine", sensors=True)
    readings = 25 + 0.1 * np.round(np.random.default_rng(1).normal(0, 1, len(log)))
    readings[-14:] = [25.4, 25.3] * 6 + [25.4, 25.0]
    columns = {**log.columns, "temperature.j1": readings}
    assert objections(replace(log, columns=columns), described("one_axis", "sine")) == []
    readings[-1] = 24.0
    said = objections(replace(log, columns=columns), described("one_axis", "sine"))
    assert any("temperature.j1: 24 at" in message for message in said)


def test_noise_of_a_coarse_column_is_no_spike_where_it_happens_to_be_still_around():
    """A thermometer that reads in tenths: half a kelvin off, among twelve rows within a tenth."""
    log = clean_log("one_axis", "sine", sensors=True)
    readings = 25 + 0.1 * np.round(np.random.default_rng(1).normal(0, 1, len(log)))
    readings[200:224] = 25.0 + 0.1 * (np.arange(24) % 2)
    readings[212] = 25.5
    columns = {**log.columns, "temperature.j1": readings}
    assert objections(replace(log, columns=columns), described("one_axis", "sine")) == []
    readings[212] = 26.0
    said = objections(replace(log, columns=columns), described("one_axis", "sine"))
    assert any("temperature.j1: 26 at" in message for message in said)

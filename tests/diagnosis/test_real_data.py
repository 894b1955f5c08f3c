"""Diagnoses of recorded machines: what their publications and plain least squares say must be named, and nothing else.

They need the published recordings, see FFGYM_DATA.
"""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.diagnosis import diagnose
from ffgym.diagnosis.extended import save_extended
from ffgym.diagnosis.held_out import compare_replays
from ffgym.diagnosis.nominal import fit_nominal
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.procedure import examine
from ffgym.effects import EFFECTS
from ffgym.logs import read_log, read_logs
from ffgym.paths import joint_reference, multisine
from ffgym.recordings import Recording
from ffgym.robot import load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine, load_machine

needs_data = pytest.mark.skipif(
    not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with the published recordings"
)


def published(folder, file, columns):
    """A recording without set-points, which published controllers do not follow as the description's servo would."""
    recording = read_log(Path(os.environ["FFGYM_DATA"]) / folder / file, columns)
    kept = {name: values for name, values in recording.columns.items() if not name.startswith("reference.")}
    return Recording(kept, recording.header)


def every_fourth(recording):
    """A quarter of the rows, which is enough for friction: 250 Hz of 1 kHz."""
    return Recording({name: values[::4] for name, values in recording.columns.items()}, recording.header)


def causes(diagnosis):
    return {(cause.effect, cause.joint): cause for cause in diagnosis.causes}


def turns_of(diagnosis, joint):
    """How often the torque of a joint, as the causes leave it, repeats per turn of its motor."""
    own = [p for p in diagnosis.patterns if (p.channel, p.component) == ("torque", joint)]
    return [p.frequency for p in own if p.kind == "periodic"]


def value(cause, name):
    """A size with its interval."""
    (size,) = [size for size in cause.parameters if size.name == name]
    return size.value, size.interval


LAP = 6.24
"""Time in which the ball screw goes there and back [s]; each of its recordings has four such laps."""

NEWTON = 2 * np.pi / 2.5e-3
"""Force on the carriage per torque of the motor [N/(N m)]: a turn of the screw is 2.5 mm."""


@pytest.fixture(scope="module")
def ball_screw():
    """Diagnosis of the ball screw by its longer recording."""
    return examine(load_robot("ball_screw"), [every_fourth(published("emps", "emps_id.npz", "emps"))])


def held_out_forces(examined, recording, folder):
    """RMS of force that the nominal model and the extended one leave of a recording, read from its file again [N]."""
    save_extended(folder / "extended.toml", examined.diagnosis, examined.nominal)
    written = load_machine(folder / "extended.toml")
    (level,) = compare_replays(examined.nominal, written, [recording])
    return level.before * NEWTON, level.after * NEWTON


def check_asymmetry(diagnosis):
    """Viscous friction 166.7 forwards, 240.4 N s/m backwards by least squares; no offset, and nothing that drifts."""
    found = causes(diagnosis)
    assert diagnosis.verdict in ("named", "partly")
    size, (low, high) = value(found["asymmetry", "x"], "viscous")
    assert low < size < high
    assert size == pytest.approx(-0.18, abs=0.02)
    assert not {effect for effect, _ in found} & {"torque_offset", "viscous_drift", "coulomb_drift"}


@needs_data
def test_friction_of_the_ball_screw_depends_on_direction_and_no_offset_or_drift_is_named(ball_screw):
    """What that leaves repeats with the turns of the screw, every 2.5 mm."""
    check_asymmetry(ball_screw.diagnosis)
    assert any(turns == pytest.approx(1.0, abs=0.05) for turns in turns_of(ball_screw.diagnosis, "x"))


@needs_data
def test_the_model_that_is_written_of_the_ball_screw_foretells_the_force_of_pulses(ball_screw, tmp_path):
    """Pulses of force are in the other recording alone, and with them what makes the hump at 15 to 30 Hz."""
    before, after = held_out_forces(ball_screw, published("emps", "emps_pulses.npz", "emps"), tmp_path)
    assert after <= 2.9 < 4.0 < before


@needs_data
def test_the_model_that_is_written_of_two_laps_of_the_ball_screw_foretells_the_next_two(tmp_path):
    """1.57 N by plain least squares with friction that depends on direction, 2.16 N without."""
    recording = published("emps", "emps_id.npz", "emps")
    examined = examine(load_robot("ball_screw"), [every_fourth(recording).slice(end=2 * LAP)])
    before, after = held_out_forces(examined, recording.slice(start=2 * LAP), tmp_path)
    assert after <= 1.7 < 2.16 < before


@needs_data
@pytest.mark.slow
def test_pulses_of_force_show_a_late_torque_of_the_ball_screw_and_a_flexible_mode_is_its_rival():
    """By plain least squares 0.75 ms take 2.59 to 1.50 N; a mode near 23 Hz is what others make of the hump there."""
    diagnosis = diagnose(load_robot("ball_screw"), [published("emps", "emps_pulses.npz", "emps")])
    check_asymmetry(diagnosis)
    delay, (low, high) = value(causes(diagnosis)["torque_delay", "x"], "delay")
    assert delay == pytest.approx(0.75e-3, abs=0.1e-3)
    assert low < 0.75e-3 < high
    rivals = {rival.effect: rival for rival in diagnosis.rivals if rival.against == "torque_delay on x"}
    assert rivals["flexible_load"].held_out_gain < 0.1 * causes(diagnosis)["torque_delay", "x"].held_out_gain
    (left,) = diagnosis.levels
    assert left.after * NEWTON <= 1.5


@needs_data
@pytest.mark.slow
def test_friction_of_the_ball_screw_depends_on_direction_in_a_quarter_of_the_rows_of_the_pulses():
    """Every fourth row folds the fast part of the pulses into the band, which is in the way of all else."""
    recording = every_fourth(published("emps", "emps_pulses.npz", "emps"))
    check_asymmetry(diagnose(load_robot("ball_screw"), [recording]))


@needs_data
@pytest.mark.slow
def test_the_ball_screw_is_diagnosed_as_it_was_recorded_on_its_own_clock_under_its_own_controller():
    recording = read_log(Path(os.environ["FFGYM_DATA"]) / "emps" / "emps_id.npz", "emps")
    diagnosis = diagnose(load_robot("ball_screw"), [recording])
    assert set(causes(diagnosis)) == {("asymmetry", "x")}
    assert "1.0 cycles per turn" in diagnosis.sentence


@pytest.fixture(scope="module", params=["A", "C"])
def kr300(request):
    """Diagnosis of a recording of the KR300 with the numbers that fit it."""
    recording = published("kuka_kr300_2020", f"{request.param}.npz", "kuka_kr300_2020")
    machine, _ = fit_nominal(load_robot("kuka_kr300_r2500"), [recording])
    return diagnose(machine, [recording])


@needs_data
@pytest.mark.slow
def test_link_encoders_of_the_kr300_are_three_milliseconds_late_and_it_has_no_backlash(kr300):
    found = causes(kr300)
    latency, (low, high) = value(found["link_clock", ""], "latency")
    assert low < latency < high
    assert 2.6e-3 < latency < 3.1e-3
    assert not {effect for effect, _ in found} & {"backlash", "wrist_coupling"}
    assert not [j for effect, j in found if effect == "load_friction" and j in ("a4", "a5", "a6")]


@needs_data
@pytest.mark.slow
def test_the_torque_of_the_first_axes_of_the_kr300_repeats_eight_times_in_a_turn_of_the_motor(kr300):
    for axis in ("a1", "a2", "a3"):
        assert any(turns == pytest.approx(8.0, abs=0.05) for turns in turns_of(kr300, axis)), axis


@needs_data
@pytest.mark.slow
@pytest.mark.parametrize(("fitted", "left_out"), ["AC", "CA"])
def test_the_model_that_is_written_of_the_kr300_is_worse_on_no_axis_of_another_recording(fitted, left_out, tmp_path):
    """Late link encoders change no torque; what stands for the rest of the links' error must not either."""
    first, last = (published("kuka_kr300_2020", f"{name}.npz", "kuka_kr300_2020") for name in (fitted, left_out))
    machine, prior = fit_nominal(load_robot("kuka_kr300_r2500"), [first])
    examined = examine(machine, [first], prior=prior)
    save_extended(tmp_path / "extended.toml", examined.diagnosis, examined.nominal)
    levels = compare_replays(examined.nominal, load_machine(tmp_path / "extended.toml"), [last])
    shares = {(level.quantity, level.component): level.after / level.before for level in levels}
    assert {quantity for quantity, _ in shares} == {"torque", "link"}
    assert all(share <= (1.005 if quantity == "torque" else 0.3) for (quantity, _), share in shares.items()), shares


@needs_data
@pytest.mark.slow
def test_a_counterbalance_that_the_model_lacks_is_seen_on_its_axis_and_gravity_is_the_rival():
    """Numbers of the CAD model, but no spring: 87 % of what the torque of axis 2 lacks is a function of its angle."""
    recording = published("kuka_kr300_2020", "A.npz", "kuka_kr300_2020")
    robot = replace(load_robot("kuka_kr300_r2500"), springs=())
    diagnosis = diagnose(robot, [recording], prior=ParameterPrior.of_share(0.1))
    springs = {("gravity_term", "a2"), ("cable_pull", "a2")}
    tied = {(rival.effect, rival.joint) for rival in diagnosis.rivals if rival.tied}
    assert springs <= tied | set(causes(diagnosis))
    assert ("link_clock", "") in causes(diagnosis)
    assert not {effect for effect, _ in causes(diagnosis)} & {"backlash", "wrist_coupling"}


def parts_of_a_session(length, which):
    """Some recordings of a session of two hours, the first `length` rows of each."""
    path = Path(os.environ["FFGYM_DATA"]) / "kuka_kr300_2021_10hz" / "recordings.npz"
    recordings = read_logs(path, "kuka_kr300_2021_10hz")
    return [recordings[i].slice(end=float(recordings[i].t[0]) + 0.1 * length) for i in which]


@needs_data
@pytest.mark.parametrize(
    ("length", "which"),
    [
        pytest.param(900, (0, 3, 6, 9), marks=pytest.mark.slow),
        pytest.param(3630, (0, 3, 6, 9), marks=pytest.mark.slow),
        pytest.param(3630, range(10), marks=pytest.mark.slow),
    ],
)
def test_in_two_hours_viscous_friction_falls_and_coulomb_friction_stays_and_torque_is_a_row_late(length, which):
    recordings = parts_of_a_session(length, which)
    machine, prior = fit_nominal(load_robot("kuka_kr300_r2500"), recordings)
    diagnosis = diagnose(machine, recordings, prior=prior)
    found = causes(diagnosis)
    assert diagnosis.verdict == "partly"
    assert not {effect for effect, _ in found} & {"asymmetry", "coulomb_drift", "presliding"}
    latency, _ = value(found["torque_clock", ""], "latency")
    assert latency == pytest.approx(0.1, abs=0.015)  # one row of 10 Hz
    fallen = [cause for cause in diagnosis.causes if cause.effect == "viscous_drift"]
    assert fallen
    for cause in fallen:
        share, (low, _) = value(cause, "share")
        assert 0 < low < share
    assert [p for p in diagnosis.patterns if (p.component, p.kind) == ("a2", "sign-locked function")]


@needs_data
@pytest.mark.slow
def test_the_model_that_is_written_of_eight_recordings_foretells_the_last_two_on_every_axis(tmp_path):
    """Two hours of a machine that warms up: no axis may be worse than with nominal numbers."""
    first, last = parts_of_a_session(3630, range(8)), parts_of_a_session(3630, (8, 9))
    machine, prior = fit_nominal(load_robot("kuka_kr300_r2500"), first)
    examined = examine(machine, first, prior=prior)
    save_extended(tmp_path / "extended.toml", examined.diagnosis, examined.nominal)
    levels = compare_replays(examined.nominal, load_machine(tmp_path / "extended.toml"), last)
    torque = {level.component: level.after / level.before for level in levels}
    assert set(torque) == {"a1", "a2", "a3", "a4", "a5", "a6"}
    assert max(torque.values()) <= 1.0, torque
    assert min(torque.values()) < 0.9, torque


def as_logged(recording, rng, *families):
    """What such a machine's log has: some families at 250 Hz, with noise of encoders and current sensors."""
    columns = {"timestamp": recording.t[::4]}
    for family, noise in zip(families, (2e-5, 0.01, 1e-6), strict=False):
        names = [f"{family}.{joint}" for joint in recording.header.joints]
        columns |= {name: recording[name][::4] + rng.normal(scale=noise, size=len(recording.t[::4])) for name in names}
    return Recording(columns, recording.header)


@pytest.fixture(scope="module")
def swing():
    """Both joints of a small arm swing to and fro at several frequencies."""
    robot = load_robot("two_link")
    centre = robot.kinematics.range.mean(axis=1)
    amplitude, phases = np.array([[0.2, 0.25], [0.06, 0.08]]), np.array([[0.0, 1.5], [2.0, 0.5]])
    return joint_reference(robot, multisine(centre, amplitude, [0.4, 0.9], phases, 6.0, ramp=1.0, dwell=0.2))


def test_late_link_encoders_are_told_from_a_gap_without_published_recordings(swing):
    robot = swing.robot
    machine = Machine(robot=robot, effects=(EFFECTS["link_clock"].on(robot, latency=0.003),))
    recording = simulate([Run(reference=swing)], machine=machine, n_threads=1)[0]
    log = as_logged(recording, np.random.default_rng(0), "motor.position", "motor.effort", "link.position")
    diagnosis = diagnose(robot, [log])
    assert diagnosis.verdict == "named"
    assert set(causes(diagnosis)) == {("link_clock", "")}
    assert value(causes(diagnosis)["link_clock", ""], "latency")[0] == pytest.approx(0.003, rel=0.05)


def test_friction_that_depends_on_direction_is_no_offset_without_published_recordings(swing):
    """The model knows no friction at low speed, so that standstill does not judge it; as those of recorded machines."""
    robot = swing.robot
    plain = replace(robot, friction=replace(robot.friction, static=robot.friction.coulomb))
    machine = Machine(
        robot=plain, effects=(EFFECTS["asymmetry"].on(plain, robot.joints[0], coulomb=0.0, viscous=-0.18),)
    )
    recording = simulate([Run(reference=swing)], machine=machine, n_threads=1)[0]
    log = as_logged(recording, np.random.default_rng(0), "motor.position", "motor.effort")
    found = causes(diagnose(plain, [log]))
    assert set(found) == {("asymmetry", robot.joints[0])}
    assert value(found["asymmetry", robot.joints[0]], "viscous")[0] == pytest.approx(-0.18, abs=0.02)

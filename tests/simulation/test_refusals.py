"""Every bad argument of simulation, laws, plant and sensors is one clear error."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import DynamicLuGreEuler, DynamicLuGreExact, NoCompensation, StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.diagnosis import example_logs, friction_torques, identify_controller
from ffgym.paths import cartesian_reference, circle_test, load_motion
from ffgym.robot import ModelOptions
from ffgym.simulation import LaserTracker, Resolver, Run, SimulatedRig, SpeedLadder, plan_session, simulate
from ffgym.simulation.plant import Plant
from ffgym.studies import circle_references


@pytest.fixture(scope="module")
def run(arm):
    return Run(reference=circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1])


REFUSED = {
    "a fraction of a sub-step": (lambda r: DynamicLuGreExact(r.friction, n_substeps=1.5), "n_substeps = 1.5"),
    "no sub-step": (lambda r: DynamicLuGreEuler(r.friction, n_substeps=0), "n_substeps = 0"),
    "a law without friction": (lambda r: DynamicLuGreExact(None), "friction must be LuGreParameters"),
    "a static law without friction": (lambda r: StaticLuGre("much"), "friction must be LuGreParameters"),
    "a steepness that is not a number": (
        lambda r: StaticLuGre(r.friction, steepness=np.nan),
        "steepness must be finite",
    ),
    "a falling sign": (lambda r: StaticLuGre(r.friction, steepness=-5), "steepness = -5"),
    "half a bit": (lambda r: Resolver(bits=1.5), "resolver bits = 1.5"),
    "no physics step": (lambda r: ModelOptions(physics_dt=0), "physics_dt = 0"),
    "an unknown physics step": (lambda r: ModelOptions(physics_dt=np.nan), "physics_dt must be finite"),
    "no robot": (lambda r: Plant(r, 0), "n_robots = 0"),
    "a fraction of a thread": (lambda r: Plant(r, 1, n_threads=1.5), "n_threads = 1.5"),
    "negative threads": (lambda r: Plant(r, 1, n_threads=-1), "n_threads = -1"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_part_is_refused_when_it_is_built(irb4600, name):
    build, message = REFUSED[name]
    with pytest.raises(FFGymError, match=message):
        build(irb4600)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seed": -1}, "seed = -1"),
        ({"seed": 0.5}, "seed = 0.5"),
        ({"record_dt": np.nan}, "record_dt must be finite"),
        ({"record_dt": 0.003}, "record_dt = 0.003 s must be a multiple"),
        ({"n_threads": -1}, "n_threads = -1"),
        ({"sensors": [LaserTracker(noise=0.0, period=1.5e-3)]}, "tracker period of 0.0015 s must be a multiple"),
    ],
)
def test_a_bad_option_of_a_simulation_is_refused(arm, run, options, message):
    with pytest.raises(FFGymError, match=message):
        simulate([run], arm=arm, **options)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (lambda run, arm: {"runs": run}, r"runs must be a list of Run, got Run; put one run in a list, \[run\]"),
        (lambda run, arm: {"runs": [run.reference]}, "run must be a Run, got Reference"),
        (lambda run, arm: {"arm": arm.robot}, "arm must be a RigidArm, got RobotDescription"),
        (lambda run, arm: {"machine": "two_link"}, "machine = 'two_link' must be a Machine or a robot"),
        (lambda run, arm: {"sensors": Resolver(bits=16)}, r"sensors = Resolver.* must be a list of sensors"),
        (lambda run, arm: {"sensors": [Resolver]}, r"sensors = .* must be a list of sensors"),
    ],
)
def test_what_is_given_in_place_of_runs_arms_machines_and_sensors_is_named(arm, run, given, message):
    with pytest.raises(FFGymError, match=message):
        simulate(**{"runs": [run]} | given(run, arm))


@pytest.mark.parametrize(
    "use",
    [
        lambda robot: plan_session(robot, [SpeedLadder()]),
        lambda robot: load_motion(robot, "square"),
        lambda robot: cartesian_reference(robot, circle_test((1.2, 0.0, 1.0), 0.1)),
        lambda robot: SimulatedRig(arm=robot),
        lambda robot: friction_torques(robot, example_logs()[:1]),
        lambda robot: identify_controller(example_logs()[:1], robot),
    ],
)
def test_a_description_in_place_of_an_arm_is_named(irb4600, use):
    with pytest.raises(FFGymError, match=r"arm must be a RigidArm, got RobotDescription; RigidArm\(robot\) makes one"):
        use(irb4600)


@pytest.mark.parametrize("torque", [np.nan, np.inf, 1e11])
def test_a_torque_that_is_no_number_is_refused_where_the_engine_would_stand_still(two_link, torque):
    plant = Plant(two_link, 1)
    plant.rest(two_link.work_area.home[None])
    with pytest.raises(FFGymError, match="got a set-point or torque that is no number below 1e10"):
        plant.advance(np.full((1, 10, plant.model.nu), torque))


def test_a_law_that_is_a_class_and_a_reference_that_is_none_are_refused(run):
    with pytest.raises(FFGymError, match="law must be a feed-forward law"):
        Run(reference=run.reference, law=NoCompensation)
    with pytest.raises(FFGymError, match="reference must be a Reference"):
        Run(reference=None)
    with pytest.raises(FFGymError, match="runs is empty"):
        simulate([])


def test_a_reference_with_a_time_that_is_no_number_is_refused(run):
    with pytest.raises(FFGymError, match=r"reference t must be finite, but entry \(0,\) is nan"):
        replace(run.reference, t=np.append(np.nan, run.reference.t[1:]))


def test_a_circle_with_too_few_samples_is_refused_with_the_fastest_speed(arm):
    with pytest.raises(FFGymError, match=r"a turn takes 5\.2 samples of 0\.004 s.*at most 0\.1571 m/s"):
        circle_references(arm, ["p1"], [0.3], [0.001])


def test_the_drive_keeps_circles_with_the_fewest_samples_round(arm):
    reference = circle_references(arm, ["p1"], [0.157], [0.001])["p1", 0.157]
    recording = simulate([Run(reference=reference)], arm=arm)[0]
    rows = recording.mask(kind="circle")
    points = recording.vector("tcp_reference.position")[rows]
    centre = recording.vector("tcp_reference.position")[0]
    assert np.abs(np.linalg.norm(points - centre, axis=1) - 0.001).max() < 5e-4 * 0.001

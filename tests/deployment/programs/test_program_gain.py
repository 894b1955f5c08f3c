"""What a corrected program keeps of a gain, as our own reader runs it."""

from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ffgym import elastic_feedforward
from ffgym.deployment import plan_setpoints, write_program
from ffgym.paths import cartesian_reference, circle_test, load_motion
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Run, simulate


def rms_from_path(recording: Recording, path: np.ndarray) -> float:
    """RMS distance of the tool from points of a path [m], less the sag at its start."""
    tool = recording.vector("tcp.position")
    away, _ = cKDTree(path).query(tool - (tool[0] - path[0]))
    return float(np.sqrt(np.mean(away**2)))


def test_a_rapid_program_keeps_most_of_the_gain_if_it_counts_on_the_controllers_feed_forward(
    arm: RigidArm, irb4600: RobotDescription, tmp_path: Path
) -> None:
    area = irb4600.work_area
    assert area is not None
    circle = circle_test(irb4600.position("p1"), 0.04, radii=[0.005], normal=area.normal, dt=0.004, name="circle")
    reference, law = cartesian_reference(arm, circle), elastic_feedforward(irb4600)
    programs = [reference]
    for counts_on in ("setpoints", "program"):
        plan = plan_setpoints(reference, law, arm=arm, feedforward=counts_on)
        write_program(plan, arm, tmp_path / counts_on, "rapid", tolerance=1e-5)
        programs.append(load_motion(arm, next((tmp_path / counts_on).glob("*.mod"))).reference)
    path = arm.tcp_position(reference.q)
    recordings = simulate([Run(reference=program) for program in programs])
    none, right, wrong = (rms_from_path(recording, path) for recording in recordings)
    assert right < 0.3 * none
    assert right < 0.9 * wrong

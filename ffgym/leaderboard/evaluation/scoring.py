"""What a recording of a task says: its circles as cells of the leaderboard."""

from ffgym.leaderboard.results import Cell, Trail
from ffgym.leaderboard.tasks import Task
from ffgym.recordings import Recording
from ffgym.recordings.metrics import deviation_along
from ffgym.studies import circle_scores, in_mm

PICTURED = ("p2", 0.003)
"""Position and radius [m] of the circles that pictures show: held out, of the thesis' middle size; chosen."""
_POINTS = 120
"""Of a picture's circle: every 3 degrees."""


def trails_of(task: Task, recording: Recording) -> list[Trail]:
    """Where the tool went on the circle that pictures show, if the task has it."""
    position, radius = PICTURED
    if task.position != position or radius not in task.radii:
        return []
    phase = recording.phases_of("circle")[task.radii.index(radius)]
    deviation = deviation_along(recording, phase, _POINTS) * 1e6
    return [
        Trail(
            position=position,
            radius_mm=in_mm(radius),
            speed_mm_s=in_mm(task.speed),
            deviation_um=tuple(float(f"{x:.4g}") for x in deviation),
        )
    ]


def cells_of(task: Task, recording: Recording) -> list[Cell]:
    """Cells of a task that ran to its end.

    Raises:
        FFGymError: if the recording lacks a column.
    """
    return [
        Cell(
            split=task.split,
            position=task.position,
            speed_mm_s=in_mm(task.speed),
            **vars(score) | {"motor_rms_rad": tuple(score.motor_rms_rad)},
        )
        for score in circle_scores(recording, task.radii)
    ]


def lost_cells(task: Task) -> list[Cell]:
    """Cells of a task in which the robot stopped: no figures, which counts as the worst."""
    return [
        Cell(
            split=task.split,
            position=task.position,
            radius_mm=in_mm(radius),
            speed_mm_s=in_mm(task.speed),
            rms_mm=None,
            max_mm=None,
            rms_3d_mm=None,
            max_3d_mm=None,
            motor_rms_rad=None,
        )
        for radius in task.radii
    ]

"""The circle test of the thesis on a simulated robot: every position, radius and speed, with each feed-forward law."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from ffgym.control import DynamicLuGreExact, FeedForwardLaw, NoCompensation, StaticLuGre
from ffgym.core.effort import announce
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.measures import rms
from ffgym.paths import RADII, SPEEDS, CartesianPath, Reference, cartesian_reference, circle_test
from ffgym.paths.circles import circle_test_duration
from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error, path_errors
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation import Rig, SimulatedRig
from ffgym.simulation.run import Progress
from ffgym.studies.selection import pick, record_all


@dataclass(frozen=True, kw_only=True)
class CircleScore:
    """One circle: path error [mm] and motor error [rad]."""

    radius_mm: float
    rms_mm: float
    """RMS path error in the plane of the circle, as in the thesis."""
    max_mm: float
    rms_3d_mm: float
    """RMS path error in space."""
    max_3d_mm: float
    motor_rms_rad: list[float]
    """RMS error of each motor over lead-in, circle and lead-out."""


def circle_scores(recording: Recording, radii: Sequence[float]) -> list[CircleScore]:
    """Score the circles of these radii [m], in the order in which they were run."""
    leads = zip(recording.phases_of("lead_in"), recording.phases_of("lead_out"), strict=True)
    motors, moving, t = motor_error(recording), ~recording.mask(kind="standstill"), recording.t
    scores = []
    for error, radius, (lead_in, lead_out) in zip(path_errors(recording), radii, leads, strict=True):
        rows = moving & (t >= lead_in.start) & (t < lead_out.end)
        scores.append(
            CircleScore(
                radius_mm=in_mm(radius),
                rms_mm=error.rms * 1e3,
                max_mm=error.max * 1e3,
                rms_3d_mm=error.rms_3d * 1e3,
                max_3d_mm=error.max_3d * 1e3,
                motor_rms_rad=rms(motors[rows], 0).tolist(),
            )
        )
    return scores


def in_mm(length: float) -> float:
    """Convert a length to millimetres, without the rounding of binary fractions."""
    return round(float(length) * 1e3, 6)


@dataclass(frozen=True, kw_only=True)
class StudyCell(CircleScore):
    """One circle with one law."""

    agent: str
    plant: str
    position: str
    speed_mm_s: float


@dataclass(frozen=True, kw_only=True, eq=False)
class CircleStudy:
    """Results of a circle test."""

    robot: RobotDescription
    cells: list[StudyCell]
    recordings: dict[tuple[str, str, float], Recording] = field(repr=False)
    """Recordings by law, position and speed [m/s]; each holds all radii."""
    fingerprint: str

    @property
    def title(self) -> str:
        """Title of the robot, and of the machine under its controller if that is another one."""
        machines = dict.fromkeys(cell.plant for cell in self.cells if cell.plant != SimulatedRig.name)
        return self.robot.title + (f", machine: {', '.join(machines)}" if machines else "")

    def select(self, **wanted: object) -> list[StudyCell]:
        """Select cells whose fields equal `wanted`, e.g. agent='none', speed_mm_s=10."""
        return [cell for cell in self.cells if all(getattr(cell, key) == value for key, value in wanted.items())]

    def only(
        self,
        laws: Sequence[str] | None = None,
        positions: Sequence[str] | None = None,
        speeds: Sequence[float] | None = None,
    ) -> "CircleStudy":
        """Return the part of the study with these laws, positions and speeds [m/s]; None takes all."""
        keys = pick(self.recordings, law=laws, position=positions, speed=speeds)
        return replace(
            self,
            cells=[c for key in keys for c in self.select(agent=key[0], position=key[1], speed_mm_s=in_mm(key[2]))],
            recordings={key: self.recordings[key] for key in keys},
        )

    def join(self, other: "CircleStudy") -> "CircleStudy":
        """Return the study with the results of another study of the same robot added, none of them twice."""
        if other.fingerprint != self.fingerprint:
            raise FFGymError(f"Studies of {self.robot.name!r} and {other.robot.name!r} are of unlike robots.")
        if twice := sorted(self.recordings.keys() & other.recordings.keys()):
            raise FFGymError(f"Both studies have results of {twice[0]}; leave them out of one with `only`.")
        recordings = self.recordings | other.recordings
        return replace(self, cells=self.cells + other.cells, recordings=recordings)

    def rename(self, law: str, name: str) -> "CircleStudy":
        """Return the study with another name for a law, so that it can stand beside one of the same name."""
        cells = [replace(cell, agent=name) if cell.agent == law else cell for cell in self.cells]
        recordings = {(name if key[0] == law else key[0], *key[1:]): each for key, each in self.recordings.items()}
        return replace(self, cells=cells, recordings=recordings)


def thesis_laws(robot: RobotDescription) -> list[FeedForwardLaw]:
    """Make no compensation, static and dynamic LuGre with the robot's own friction parameters (chapter 4)."""
    return [NoCompensation(), StaticLuGre(robot.friction), DynamicLuGreExact(robot.friction)]


def circle_references(
    arm: RigidArm,
    positions: Sequence[str] | None = None,
    speeds: Iterable[float] = SPEEDS,
    radii: Sequence[float] = RADII,
) -> dict[tuple[str, float], Reference]:
    """Make references of the test motion by position and speed [m/s]; None takes every position of the work area.

    Raises:
        FFGymError: if the robot has no work area or no such position, or cannot follow the motion.
    """
    robot = arm.robot
    if robot.work_area is None:
        raise FFGymError(
            f"Robot {robot.name!r} has no work area for circles; use ffgym.studies.one_axis_study for one axis."
        )
    # grid of positions, speeds and radii, each value once
    names = list(robot.work_area.positions) if positions is None else list(positions)
    speeds = check_shape("speeds", list(speeds), (None,)).tolist()
    axes: dict[str, list[object]] = {
        "positions": [*names],
        "speeds [mm/s]": [in_mm(speed) for speed in speeds],
        "radii [mm]": [in_mm(radius) for radius in check_shape("radii", radii, (None,))],
    }
    for what, values in axes.items():
        if not values or len(set(values)) < len(values):
            raise FFGymError(f"{what} of one study must be at least one, and all different, got {values}.")
    if min(speeds) > 0 and min(radii) > 0:  # others are refused below, with words of their own
        announce(len(names) * sum(circle_test_duration(speed, radii) for speed in speeds), "plan all")
    return {
        (name, speed): cartesian_reference(arm, circle_path(robot, name, speed, radii))
        for speed in speeds
        for name in names
    }


def circle_path(robot: RobotDescription, position: str, speed: float, radii: Sequence[float] = RADII) -> CartesianPath:
    """Make the path of the test motion at a position, at a speed [m/s], with circles of `radii` [m]."""
    assert robot.work_area is not None  # it has the position
    normal, dt = robot.work_area.normal, robot.servo.control_dt
    title = f"{position}, {speed * 1e3:g} mm/s"
    return circle_test(robot.position(position), speed, radii=radii, normal=normal, dt=dt, name=title)


def circle_study(
    robot: RobotDescription | Rig,
    *,
    laws: Sequence[FeedForwardLaw] | None = None,
    positions: Sequence[str] | None = None,
    speeds: Sequence[float] = SPEEDS,
    radii: Sequence[float] = RADII,
    options: ModelOptions | None = None,
    seed: int = 0,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> CircleStudy:
    """Simulate and score the circle test.

    Args:
        robot: the robot, which is its own plant; or a rig, on which the motions are run.
        laws: feed-forward laws; None takes those of chapter 4.
        positions: names in the robot's work area; None takes all.
        speeds: TCP speeds [m/s].
        radii: circle radii [m].
        options: changes of the plant of a robot.
        seed: seed of the sensors' noise, on a rig with sensors.
        n_threads: threads of the engine, 0 for all cores.
        progress: function that is called with the simulated seconds done and their total.

    Raises:
        FFGymError: if there is nothing to simulate, two laws share a name, or the robot cannot follow the motion.
    """
    rig = robot if isinstance(robot, Rig) else SimulatedRig(arm=RigidArm(robot), options=options)
    references = circle_references(rig.arm, positions, speeds, radii)
    laws = thesis_laws(rig.robot) if laws is None else laws
    recordings = record_all(rig, references, laws, seed=seed, n_threads=n_threads, progress=progress)
    return score_circle_study(rig, recordings, radii)


def score_circle_study(
    rig: Rig, recordings: dict[tuple[str, str, float], Recording], radii: Sequence[float] = RADII
) -> CircleStudy:
    """Score recordings of the circle test on a rig.

    Args:
        rig: the rig.
        recordings: recordings by agent, position and speed [m/s].
        radii: circle radii [m].
    """
    cells = [
        StudyCell(agent=agent, plant=rig.name, position=position, speed_mm_s=in_mm(speed), **vars(score))
        for (agent, position, speed), recording in recordings.items()
        for score in circle_scores(recording, radii)
    ]
    fingerprint = str(next(iter(recordings.values())).header.provenance["physics_fingerprint"])
    return CircleStudy(robot=rig.robot, cells=cells, recordings=recordings, fingerprint=fingerprint)

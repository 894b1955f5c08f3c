"""Plant + controller + path (+ feed-forward) -> recordings, whole batches at once."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ffgym.control import FeedForwardLaw, NoCompensation, SetpointChannel, Setpoints
from ffgym.control.corrections import difference_speeds
from ffgym.core.errors import FFGymError, check_class, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation.plant import Machine, Plant
from ffgym.simulation.sensors import Sensor, check_sensors, measure
from ffgym.simulation.trace import Added, ReferenceRows, Trace, to_recording

RECORD_DT = 0.001
"""Default sample time of recordings [s]: the laser tracker's (thesis 2.2.4)."""

_CHUNK = 32
"""Control steps in one call of the engine; chosen: from 4 to 32 the engine's time changes by less than 3 %."""

Progress = Callable[[float, float], None]
"""Called with the simulated seconds done and their total."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """Motion with a feed-forward law."""

    reference: Reference
    law: FeedForwardLaw = field(default_factory=NoCompensation)
    channel: SetpointChannel | None = None
    """Set-point channel that the law acts through; None adds its torque to the motors'."""

    def __post_init__(self) -> None:
        if not isinstance(self.reference, Reference):
            raise FFGymError(f"reference must be a Reference, see ffgym.control, got {self.reference!r}.")
        if not isinstance(self.law, FeedForwardLaw):
            raise FFGymError(f"law must be a feed-forward law, e.g. NoCompensation(), got {self.law!r}.")
        if not isinstance(self.channel, SetpointChannel | None):
            raise FFGymError(f"channel must be a SetpointChannel or None, got {self.channel!r}.")


def simulate(
    runs: Sequence[Run],
    *,
    arm: RigidArm | None = None,
    machine: Machine | RobotDescription | Sequence[Machine | RobotDescription] | None = None,
    options: ModelOptions | None = None,
    sensors: Sequence[Sensor] = (),
    seed: int | Sequence[np.random.Generator] = 0,
    record_dt: float = RECORD_DT,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> list[Recording]:
    """Simulate runs of one robot side by side; the result of a run does not depend on the others.

    Args:
        runs: what to simulate; all references must be for the same robot description.
        arm: the robot's rigid dynamics, if the caller has them already.
        machine: what is simulated under the controller of the references' robot; one for all runs or one each. None is
            that robot itself.
        options: what to leave out of the plant, or another physics step.
        sensors: models of what is measured, applied in order; what neither they nor the drive know is left out.
            None gives the exact state.
        seed: seed of the sensor noise, of which run i uses the i-th stream spawned from it; or a generator each.
        record_dt: sample time of the recordings [s]; a multiple of the physics step that divides the control step.
        n_threads: threads of the engine, 0 for all cores.
        progress: called now and then with the simulated seconds done and their total.

    Raises:
        FFGymError: if there is nothing to simulate, robots differ, times do not fit, or a simulation becomes unstable.
    """
    robot = one_robot(runs)
    check_sensors(sensors)
    generators = (
        seed if isinstance(seed, Sequence) else np.random.default_rng(check_whole("seed", seed, low=0)).spawn(len(runs))
    )
    if len(generators) != len(runs):
        raise FFGymError(
            f"There are {len(generators)} generators for {len(runs)} runs; give a seed, or one generator each."
        )
    if isinstance(machine, str):
        raise FFGymError(f"machine = {machine!r} must be a Machine or a robot; load_machine or load_robot makes one.")
    machines = list(machine) if isinstance(machine, Sequence) else [machine or robot] * len(runs)
    if len(machines) != len(runs):
        raise FFGymError(f"There are {len(machines)} machines for {len(runs)} runs; give one for all, or one each.")
    arm = RigidArm(robot) if arm is None else arm
    check_class("arm", arm, RigidArm, "RigidArm(robot) makes one of a description")
    plant = Plant(machines[0], len(runs), options=options, n_threads=n_threads)
    plant.check_controller(robot)
    plant.become(range(len(runs)), machines)
    stride = record_stride(plant, record_dt)
    # rows of each reference, once however many runs share it
    shared = {
        id(run.reference): ReferenceRows.of(arm, run.reference, plant.n_substeps // stride)
        for run in {id(run.reference): run for run in runs}.values()
    }
    # feedforward torque: rigid-body part of the reference, and what the law adds to torques or set-points
    added = [_act(run, u_lff) for run, u_lff in zip(runs, _compute_added_torques(runs), strict=True)]
    total = [shared[id(run.reference)].u_ff + each.torque for run, each in zip(runs, added, strict=True)]
    traces = _run(plant, arm, runs, _setpoints(runs, total, [each.correction for each in added]), stride, progress)
    # exact signals of each run, then its sensors
    recordings = []
    named = None if isinstance(seed, Sequence) else int(seed)
    for i, (run, trace, each, rng) in enumerate(zip(runs, traces, added, generators, strict=True)):
        rows = shared[id(run.reference)]
        exact = to_recording(trace, rows, law=run.law.name, added=each, arm=arm, plant=plant, index=i, seed=named)
        recordings.append(measure(plant.machines[i].seen(exact), sensors, rng))
    return recordings


def one_robot(runs: Sequence[Run]) -> RobotDescription:
    """Return the one robot of all references."""
    if not isinstance(runs, Sequence):
        raise FFGymError(f"runs must be a list of Run, got {type(runs).__name__}; put one run in a list, [run].")
    if not runs:
        raise FFGymError("There is nothing to simulate: runs is empty.")
    for run in runs:
        check_class("run", run, Run, "Run(reference=reference) makes one")
    robots = {id(run.reference.robot): run.reference.robot for run in runs}
    if len(robots) > 1:
        names = sorted(robot.name for robot in robots.values())
        raise FFGymError(f"Runs of one batch must share one robot description, got {names}; simulate them one by one.")
    return runs[0].reference.robot


def record_stride(plant: Plant, record_dt: float) -> int:
    """Compute the number of physics steps between samples that are recorded every `record_dt` [s]."""
    record_dt = check_number("record_dt", record_dt, unit="s", low=0.0, open_low=True)
    stride = round(record_dt / plant.physics_dt)
    if stride < 1 or abs(stride * plant.physics_dt - record_dt) > 1e-9 or plant.n_substeps % stride:
        raise FFGymError(
            f"record_dt = {record_dt} s must be a multiple of physics_dt = {plant.physics_dt} s that divides "
            f"control_dt = {plant.robot.servo.control_dt} s."
        )
    return stride


def _compute_added_torques(runs: Sequence[Run]) -> list[Array]:
    """Compute the torque that each law adds, motor side [N m], (T, N); it is 0 at t = 0, before any law runs.

    All references of one law are given to it at once.
    """
    by_law: dict[int, list[int]] = {}
    for i, run in enumerate(runs):
        by_law.setdefault(id(run.law), []).append(i)
    added: dict[int, Array] = {}
    for rows in by_law.values():
        law, references = runs[rows[0]].law, [runs[i].reference for i in rows]
        for i, torque in zip(rows, law.torques_along(references), strict=True):
            name = f"torque of feed-forward law {law.name!r}"
            added[i] = check_shape(name, torque, runs[i].reference.q.shape).copy()
            added[i][0] = 0.0
    return [added[i] for i in range(len(runs))]


def _act(run: Run, torque: Array) -> Added:
    """Return what a law adds to the torques or, through its channel, to the set-points."""
    if run.channel is None:
        return Added(torque=torque)
    servo = run.reference.robot.servo
    return Added(torque=np.zeros_like(torque), correction=run.channel.correct(servo, torque))


def _setpoints(runs: Sequence[Run], torques: Sequence[Array], corrections: Sequence[Array | None]) -> Setpoints:
    """Stack set-points of all runs; a short run holds its last sample, which is never used."""
    length = max(len(run.reference.t) for run in runs)
    robot = runs[0].reference.robot
    positions, velocities = [run.reference.motor_q for run in runs], [run.reference.motor_dq for run in runs]
    for i, correction in enumerate(corrections):
        if correction is not None:
            positions[i] = positions[i] + correction
            velocities[i] = velocities[i] + difference_speeds(correction, robot.servo.control_dt)

    def stack(series: list[Array]) -> Array:
        return np.stack([np.pad(x, ((0, length - len(x)), (0, 0)), mode="edge") for x in series])

    return Setpoints(
        position=stack(positions),
        velocity=stack(velocities),
        torque=stack(list(torques)),
        dt=robot.servo.control_dt,
    )


def _run(
    plant: Plant, arm: RigidArm, runs: Sequence[Run], setpoints: Setpoints, stride: int, progress: Progress | None
) -> list[Trace]:
    """Step all plants through their set-points; runs that have ended drop out."""
    steps = [len(run.reference.t) - 1 for run in runs]
    per_step = plant.n_substeps // stride
    traces = [Trace.empty(plant, n * per_step + 1, stride * plant.physics_dt) for n in steps]
    # begin on the reference, springs bent by the load
    start_q = np.stack([run.reference.q[0] for run in runs])
    start_dq = np.stack([run.reference.dq[0] for run in runs])
    plant.rest(start_q, start_dq)
    for i, trace in enumerate(traces):
        first = (plant.batch.qpos, plant.batch.qvel, plant.batch.act, plant.reading())
        trace.write(0, (None if part is None else part[i : i + 1] for part in first))
    fractions = np.arange(plant.n_substeps) / plant.n_substeps
    done, total, step = 0, sum(steps), 0
    if progress is not None:
        progress(0.0, total * setpoints.dt)
    while done < total:
        # advance together the runs that last, at most to the end of the shortest
        active = np.flatnonzero(np.array(steps) > step)
        stop = min(step + _CHUNK, *(n for n in steps if n > step))
        controls = np.empty((len(active), stop - step, plant.n_substeps, plant.model.nu))
        setpoints.between(active, step, stop, fractions, out=plant.split_controls(controls))
        # keep the states of rows that are recorded
        history = plant.advance_with_readings(controls.reshape(len(active), -1, plant.model.nu), ids=active)
        for row, trace in enumerate(traces[i] for i in active):
            kept = (None if part is None else part[row, stride - 1 :: stride] for part in history)
            trace.write(step * per_step + 1, kept)
        done += len(active) * (stop - step)
        step = stop
        if progress is not None:
            progress(done * setpoints.dt, total * setpoints.dt)
    return traces

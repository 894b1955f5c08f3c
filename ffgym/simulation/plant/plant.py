"""Many copies of one robot, stepped together by MuJoCo; motor quantities go in and come out in motor units."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.errors import FFGymError, check_shape, check_whole
from ffgym.core.types import Array, IntArray
from ffgym.robot import ModelOptions, RobotDescription, model_field, physics_fingerprint
from ffgym.simulation.plant.engine_state import Addresses, PlantState, servo_reader
from ffgym.simulation.plant.forces import READING, Forces
from ffgym.simulation.plant.machine import Machine, check_same_controller
from ffgym.simulation.plant.settling import Settling, bent_by_load

_BAD = [
    int(mujoco.mjtWarning.mjWARN_BADQPOS),
    int(mujoco.mjtWarning.mjWARN_BADQVEL),
    int(mujoco.mjtWarning.mjWARN_BADQACC),
]
"""Warnings of the engine that a simulation is unstable."""
_BAD_CONTROL = int(mujoco.mjtWarning.mjWARN_BADCTRL)
"""Warning of the engine that a control is no number, or larger than 1e10; it then stands still."""
MAX_THREADS = 1024
"""More threads than any machine has cores; a larger number is a slip."""


SavedPlant = tuple[list[Machine], Array, Forces | None, list[Array]]
"""Snapshot of a plant: machines, state of the engine, forces, and memories of effects."""


class Plant:
    """B simulations of one robot with servos, on `n_threads` threads (0: all cores); one robot is the batch of one.

    The batch's results are bit-identical at any number of threads and robots.
    """

    def __init__(
        self,
        robot: RobotDescription | Machine,
        n_robots: int,
        *,
        options: ModelOptions | None = None,
        n_threads: int = 0,
    ) -> None:
        options = options or ModelOptions(looks=False)
        if not options.servo:
            raise FFGymError("A plant needs its servos; leave ModelOptions.servo at True.")
        n_robots = check_whole("n_robots", n_robots, low=1)
        n_threads = check_whole("n_threads", n_threads, low=0, high=MAX_THREADS)
        # one compiled model for all, until robots become different
        machine = Machine.of(robot)
        self.robot = robot = machine.robot
        self._first = machine
        self.machines = [machine] * n_robots
        """Machine of each simulation: the first one, or the one that it has `become`."""
        self._options = options
        self.model = machine.spec(options).compile()
        self.batch = batch.Batch(self.model, nsim=n_robots, nthread=n_threads)
        self._qpos, self._qvel, self._act = (self.batch.bind(name) for name in ("qpos", "qvel", "act"))
        self._time, self._warnings = self.batch.bind("time"), self.batch.warning[..., 1]
        self._warned = self._warnings.copy()
        # whole number of physics steps in a control step
        self.physics_dt = float(self.model.opt.timestep)
        self.n_substeps = round(robot.servo.control_dt / self.physics_dt)
        if abs(self.n_substeps * self.physics_dt - robot.servo.control_dt) > 1e-9 or self.n_substeps < 1:
            raise FFGymError(
                f"physics_dt = {self.physics_dt} s must divide control_dt = {robot.servo.control_dt} s exactly."
            )
        self.addresses = Addresses.of(self.model, robot)
        self._has_springs = bool(robot.springs) and options.springs
        self._read_servo = servo_reader(self.batch, self.addresses, robot.drive)
        self._forces = self._make_forces()

    @property
    def n_robots(self) -> int:
        """Number of simulations B."""
        return int(self.batch.nsim)

    @property
    def robots(self) -> list[RobotDescription]:
        """Robot of each simulation, with native effects as changes of its numbers."""
        return [machine.physical for machine in self.machines]

    def check_controller(self, robot: RobotDescription) -> None:
        """Check that a controller made for `robot` fits this plant, and this plant's a robot.

        Raises:
            FFGymError: if joints, gear ratios, servo gains, sample times or the make of springs and tool differ.
        """
        check_same_controller(self.robot, robot)

    def fingerprint(self, index: int = 0) -> str:
        """Fingerprint of the physics of one simulation."""
        machine = self.machines[index]
        if machine.is_as(self._first):
            return machine.fingerprint(self._first_fingerprint)
        return machine.fingerprint(physics_fingerprint(machine.spec(self._options).compile()))

    @cached_property
    def _first_fingerprint(self) -> str:
        """Fingerprint of the compiled model, which each recording of it names."""
        return physics_fingerprint(self.model)

    def become(self, ids: Sequence[int] | IntArray, robots: Sequence[RobotDescription | Machine]) -> None:
        """Give simulations `ids` other physics: masses, stiffness, friction, ... of `robots`; then put them to `rest`.

        All others go on as if nothing had happened.

        Raises:
            FFGymError: if a robot differs in what its controller knows: joints, gear ratios, servo, sample times; or in
                which joints are elastic, which bodies springs join, or whether there is a tool.
        """
        machines = [Machine.of(robot) for robot in robots]
        if len(machines) != len(ids):
            raise FFGymError(f"There are {len(machines)} robots for {len(ids)} simulations; give one each.")
        # compile only the models that change; a batch shares the layout of its states
        changed = [(i, m) for i, m in zip(ids, machines, strict=True) if not m.is_as(self.machines[i])]
        models = []  # all of them before any is given
        for _, machine in changed:
            self.check_controller(machine.robot)
            models.append(machine.spec(self._options).compile())
            if _make(models[-1]) != _make(self.model):
                raise FFGymError(
                    f"Robot {machine.robot.name!r} has other elastic joints, joints of effects, actuators or torque "
                    f"loops than the other simulations of the same batch; simulate it in a batch of its own. An "
                    f"arm_share can be drawn on joints of a robot that has one, as irb4600_60_205_arm_losses."
                )
        # give each simulation the fields in which its model differs
        for (i, machine), model in zip(changed, models, strict=True):
            for name in batch.MODEL_FIELDS:
                own = model_field(model, name)
                if self.batch.expanded(name) is not None or not np.array_equal(own, model_field(self.model, name)):
                    self.batch.expand(name)[i] = own
            self.machines[i] = machine
        # forces of the new machines; the others keep their memory
        if changed:
            before, self._forces = self._forces, self._make_forces()
            if before is not None and self._forces is not None:
                others = np.setdiff1d(np.arange(self.n_robots), [i for i, _ in changed])
                self._forces.go_on_from(before, others)

    def _make_forces(self) -> Forces | None:
        """Forces beside the engine's own physics; None if there are no such effects."""
        self.batch.bind("qfrc_applied")[:] = 0.0
        if not Forces.needed(self.machines):
            return None
        return Forces(self.batch, self.addresses, self.machines)

    def rest(self, motor_q: Array, motor_dq: Array | None = None, ids: IntArray | None = None) -> None:
        """Put robots into static equilibrium: springs and servo integrals carry gravity, bristles are relaxed.

        Args:
            motor_q: joint position at the gearbox output as resolvers read it [rad], shape (B, N).
            motor_dq: joint speed at the gearbox output [rad/s], shape (B, N); None is at rest.
            ids: which robots, shape (B,); None is all.

        Raises:
            FFGymError: if a robot is so soft that it finds no equilibrium under gravity.
        """
        n, at, engine = self.robot.n_joints, self.addresses, self.batch
        rows = np.arange(self.n_robots) if ids is None else np.asarray(ids)
        motor_q = check_shape("motor_q", motor_q, (len(rows), n))
        speed = np.zeros_like(motor_q) if motor_dq is None else check_shape("motor_dq", motor_dq, (len(rows), n))
        # motor angles that the resolvers read as those wanted
        if self._forces is not None:
            motor_q = self._forces.read_as(self._forces.choose(rows), motor_q)
        engine.reset(rows, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self._warned[rows] = self._warnings[rows]
        self._qpos[np.ix_(rows, at.motor_qpos)] = motor_q
        # deflection of the springs under the load at rest
        robots = [self.machines[i].physical for i in rows]
        bends = self._forces is not None and self._forces.bends.any()
        load = np.zeros_like(motor_q)
        if np.any(self.model.opt.gravity) or self._has_springs or bends:
            effects = self._settling if bends else None
            load = bent_by_load(engine, at, rows, robots, has_springs=self._has_springs, effects=effects)
        settling = None if self._forces is None else self._settling(rows)
        held = self.robot.drive.motor_torque(load) if settling is None else settling.servo_torque(load)
        self._qvel[np.ix_(rows, at.motor_qpos)] = speed
        # integrators hold the load, so that the first step does not jerk
        gain = np.stack([robot.servo.integral_gain for robot in robots])
        integral = np.divide(held, gain, out=np.zeros_like(held), where=gain > 0)
        self._act[np.ix_(rows, at.integral[at.has_integral])] = integral[:, at.has_integral]
        if at.has_torque.any():  # and torque loops give what integrators command
            peak = np.stack([robot.drive.peak_torque for robot in robots])
            given = np.clip(gain * integral, -peak, peak)
            self._act[np.ix_(rows, at.torque[at.has_torque])] = given[:, at.has_torque]
        if settling is not None:
            settling.begin()

    def _settling(self, rows: IntArray) -> Settling:
        assert self._forces is not None
        return Settling(self._forces, rows, self.robot.drive)

    def save(self) -> SavedPlant:
        """All that may change, to go back to it."""
        remembered = [] if self._forces is None else self._forces.copy_memories()
        return self.machines.copy(), self.batch.state.copy(), self._forces, remembered

    def restore(self, saved: SavedPlant) -> None:
        """Go back, to the bit."""
        machines, engine, forces, remembered = saved
        self.become(range(self.n_robots), machines)
        self.batch.state[:], self._forces = engine, forces
        if forces is not None:
            forces.remember(remembered)

    def state(self) -> PlantState:
        """State of all robots now, arrays of shape (B, N), copies."""
        return self.unpack(self._qpos, self._qvel, self._act)

    def servo_state(self) -> Array:
        """Return motor position [rad], speed [rad/s] and integral [rad s] of the servos, motor side, (3, B, N), a copy.

        Position and speed are those that the resolver reads, if the machine has a resolver with an error.
        """
        state = self._read_servo()
        if self._forces is not None:
            error = self._forces.resolver_error(state[0], state[1])
            state[0] += error.angle
            state[1] += error.speed
        return state

    def unpack(self, qpos: Array, qvel: Array, act: Array) -> PlantState:
        """State from MuJoCo's arrays of any leading shape, motor quantities in motor units."""
        return PlantState.of(self.addresses, self.robot.drive, qpos, qvel, act)

    def tcp_position(self, index: int, qpos: Array) -> Array | None:
        """TCP [m] (T, 3) of a simulation at MuJoCo's joint positions (T, nq), if that takes more than link positions.

        None for a machine of which the links know all.
        """
        if not self.addresses.extra_qpos.size or self.robot.tool is None:
            return None
        model = self.machines[index].spec(self._options).compile()
        data, site = mujoco.MjData(model), model.site("tcp").id
        points = np.empty((len(qpos), 3))
        for point, position in zip(points, qpos, strict=True):
            data.qpos[:] = position
            mujoco.mj_kinematics(model, data)
            point[:] = data.site_xpos[site]
        return points

    def split_controls(self, controls: Array) -> tuple[Array, Array, Array]:
        """Set-points for position, velocity, torque (..., N) as views of MuJoCo's controls (..., 3 N), motor side."""
        position, velocity, torque = (controls[..., k::3] for k in range(3))
        return position, velocity, torque

    def advance(self, controls: Array, ids: IntArray | None = None) -> tuple[Array, Array, Array]:
        """Run physics steps with one row of `controls` (B, S, 3 N) each; returns qpos, qvel, act after every step.

        Raises:
            FFGymError: if a simulation becomes unstable.
        """
        out = self._roll(controls, ("qpos", "qvel", "act"), ids)
        return out["qpos"], out["qvel"], out["act"]

    def advance_with_readings(
        self, controls: Array, ids: IntArray | None = None
    ) -> tuple[Array, Array, Array, Array | None]:
        """Run physics steps as `advance` does; returns qpos, qvel, act, and what servos read, see `reading`."""
        reads = self._forces is not None and self._forces.has_readings
        names = ("qpos", "qvel", "act", *((READING,) if reads else ()))
        out = self._roll(controls, names, ids)
        return out["qpos"], out["qvel"], out["act"], out.get(READING)

    def reading(self) -> Array | None:
        """Motor angles [rad], then speeds [rad/s], as servos know them now, motor side, (B, 2 N).

        None if no drive of the batch reads its resolver, see `drive.resolver_period`: servos know the true ones.
        """
        return self._forces.reading() if self._forces is not None and self._forces.has_readings else None

    def drive(self, controls: Array, ids: IntArray | None = None) -> None:
        """Advance as `advance` does, and keep the state at the end alone."""
        self._roll(controls, (), ids)

    def _roll(self, controls: Array, record: tuple[str, ...], ids: IntArray | None) -> dict[str, Array]:
        steps = controls.shape[1]
        began = self._time.copy()
        # without warnings that MuJoCo prints and writes to a file: an unstable simulation is an error of ours
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(_ignore)
        try:
            if self._forces is None:
                out: dict[str, Array] = self.batch.rollout(steps, control=controls, record=record, ids=ids)
            else:
                out = self._forces.rollout(self.batch, controls, record, ids)
        finally:
            mujoco.set_mju_user_warning(before)
        if np.count_nonzero(self._warnings):
            warned, self._warned = self._warnings > self._warned, self._warnings.copy()
            for wrong, what, way_out in (
                (
                    warned[:, [_BAD_CONTROL]],
                    "got a set-point or torque that is no number below 1e10",
                    "Give finite ones.",
                ),
                (
                    warned[:, _BAD],
                    "became unstable",
                    f"Lower servo gains, torques or the physics step of {self.physics_dt} s.",
                ),
            ):
                failed = np.flatnonzero(wrong.any(axis=1))
                if failed.size:
                    first = int(failed[0])
                    raise FFGymError(
                        f"Simulation {first} of robot {self.robot.name!r} {what} between t = {began[first]:.3f} s and "
                        f"{began[first] + steps * self.physics_dt:.3f} s. {way_out}"
                    )
        return out


def _make(model: mujoco.MjModel) -> tuple[Any, ...]:
    """Return the structure that all models of a batch must share; they differ in numbers alone."""
    parts = ((model.joint, model.njnt), (model.actuator, model.nactuator))
    names = [part(i).name for part, count in parts for i in range(count)]
    return model.nu, model.na, names, model.actuator_dyntype.tolist()


def _ignore(_: str) -> None:
    """Print no warning."""

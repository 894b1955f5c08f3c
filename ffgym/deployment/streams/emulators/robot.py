r"""Robot of an emulator: a simulated machine behind the delay and the filter of a controller.

A set-point that the controller gets at t reaches the servo as

.. math:: \theta_{ref}(t) = F \{ G q_{set} \}(t), \quad F(s) = e^{-d s} / (1 + a_1 s + a_2 s^2)

straight between set-points; the speed reference is its derivative. The rigid feed-forward of the controller is that of
`ffgym.control.rigid_feedforward`, computed from this reference.
"""

from typing import Literal, final

import numpy as np
from scipy import signal

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.deployment.streams.recording import header_of
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation.plant import Machine, Plant

Missing = Literal["hold", "extrapolate"]
"""What a controller does in a cycle without a set-point: keep the last one, or go on at its speed."""


@final
class EmulatedRobot:
    """One robot, advanced a cycle of its controller at a time."""

    def __init__(
        self,
        machine: Machine | RobotDescription,
        start: Array,
        *,
        cycle: float,
        response: SetpointResponse,
        arm: RigidArm | None = None,
        feedforward: bool = True,
        missing: Missing = "hold",
        program: Array | None = None,
        options: ModelOptions | None = None,
    ) -> None:
        """Put a robot to rest.

        Args:
            machine: what is simulated.
            start: joint positions, link side [rad or m], shape (N,).
            cycle: time between set-points [s].
            response: delay and filter of the controller; a delay is at least a cycle, since set-points are joined by
                straight lines.
            arm: rigid dynamics that the controller knows; None takes those of the machine's robot.
            feedforward: True if the controller computes rigid feed-forward.
            missing: what it does in a cycle without a set-point.
            program: joint positions at each cycle of a program that the controller runs by itself, link side, shape
                (T, N), which begins at `start`; set-points are then corrections of it, and they alone are delayed and
                filtered. None takes positions.
            options: what to leave out of the plant, or another physics step.

        Raises:
            FFGymError: if times do not fit.
        """
        check_choice("behaviour without set-point", missing, ("hold", "extrapolate"))
        self.plant = Plant(machine, 1, options=options, n_threads=1)
        self.robot, self.cycle, self.response = self.plant.robot, cycle, response
        self._step = self.plant.physics_dt
        self._acceleration = np.zeros(len(start))
        self._substeps = round(cycle / self._step)
        if abs(self._substeps * self._step - cycle) > 1e-9:
            raise FFGymError(f"The physics step of {self._step} s must divide the cycle of {cycle} s.")
        if response.delay < cycle - 1e-12:
            raise FFGymError(
                f"delay = {1e3 * response.delay:g} ms must be at least the cycle of {1e3 * cycle:g} ms: the controller "
                f"joins set-points by straight lines."
            )
        self._arm = (arm or RigidArm(self.robot)) if feedforward else None
        self._missing = missing
        self.plant.rest(start[None])
        # set-points so far, oldest first, one a cycle; at rest before the start
        self._program = program
        rest = start if program is None else np.zeros_like(start)
        kept = int(np.ceil(response.delay / cycle)) + 2
        self._received = [rest.copy() for _ in range(kept)]
        self._filter = _StreamingFilter(response, self._step, rest)
        self._run_cycles = 0
        self.runs = False
        """True while the controller runs its program; set it to begin."""
        self._reference = np.tile(self.robot.drive.motor_angle(start), (2, 1))
        self._rates = np.zeros((2, len(start)))
        self._feedforward = np.zeros(len(start))
        self._rows: list[tuple[Array, Array, Array, Array, Array]] = []
        self.cycles = 0
        """Cycles so far."""
        self.missed = 0
        """Cycles without a set-point."""

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.cycles * self.cycle

    @property
    def position(self) -> Array:
        """Joint positions that the resolvers read, link side [rad or m], shape (N,)."""
        return self.robot.drive.joint_angle(self.plant.servo_state()[0, 0])

    @property
    def motor_speed(self) -> Array:
        """Motor speeds that the resolvers read [rad/s], shape (N,)."""
        return np.asarray(self.plant.servo_state()[1, 0])

    @property
    def planned(self) -> Array:
        """Set-point that the servo tracks now, link side [rad or m], shape (N,)."""
        return self.robot.drive.joint_angle(self._reference[-1])

    @property
    def has_ended(self) -> bool:
        """True once the controller has come to the end of its program."""
        return self._program is not None and self._run_cycles >= len(self._program) - 1

    def advance(self, setpoint: Array | None, torque: Array | None = None) -> None:
        """Simulate a cycle.

        Args:
            setpoint: set-point that came at its beginning, link side [rad or m], shape (N,); None if none came.
            torque: torque to add over the whole cycle, motor side [N m], shape (N,).

        Raises:
            FFGymError: if the robot becomes unstable.
        """
        self.missed += setpoint is None
        self._received = [*self._received[1:], self._fill() if setpoint is None else setpoint]
        reference, speed = self._reference_of_cycle()
        controls = np.empty((1, self._substeps, 3 * self.robot.n_joints))
        position, velocity, effort = self.plant.split_controls(controls)
        position[0], velocity[0] = reference[:-1], speed[:-1]
        effort[0] = self._torques(reference, speed) + (0.0 if torque is None else torque)
        states = self.plant.advance(controls)
        self._note(reference[1:], states)
        self._reference, self.cycles = reference, self.cycles + 1

    def truth(self, segment: str) -> Recording:
        """Make the recording of all cycles so far, with the true states, at every physics step.

        Times count from the start of the robot. `reference.*` is what the servo tracked.
        """
        if not self._rows:
            raise FFGymError("The robot has not moved yet; run it before its truth is asked for.")
        reference, speed, qpos, qvel, act = (np.concatenate(part) for part in zip(*self._rows, strict=True))
        state = self.plant.unpack(qpos, qvel, act)
        families = {
            "reference.position": reference,
            "reference.velocity": speed,
            "motor.position": state.motor_position,
            "motor.velocity": state.motor_velocity,
            "link.position": state.link_position,
            "link.velocity": state.link_velocity,
        }
        joints = self.robot.joints
        columns: dict[str, Array] = {"timestamp": np.arange(1, len(qpos) + 1, dtype=np.float64) * self._step}
        columns |= {f"{name}.{joint}": x[:, j] for name, x in families.items() for j, joint in enumerate(joints)}
        if self.robot.tool is not None:
            moved = self.plant.tcp_position(0, qpos)
            tcp = RigidArm(self.robot).tcp_position(state.link_position) if moved is None else moved
            columns |= {f"tcp.position.{axis}": tcp[:, k] for k, axis in enumerate("xyz")}
        provenance = {
            "simulated": True,
            "physics_fingerprint": self.plant.fingerprint(),
            "physics_dt": self._step,
        }
        return Recording(columns=columns, header=header_of(self.robot, segment, provenance=provenance))

    def _fill(self) -> Array:
        """Set-point of a cycle in which none came."""
        last, before = self._received[-1], self._received[-2]
        return last + (last - before) if self._missing == "extrapolate" else last

    def _reference_of_cycle(self) -> tuple[Array, Array]:
        """Compute position and speed references at the physics steps of a cycle and its end, motor side."""
        times = np.arange(1, self._substeps + 1) * self._step - self.response.delay
        # the last set-point came at the beginning of this cycle, time 0
        places = np.minimum(times / self.cycle + len(self._received) - 1, len(self._received) - 1)
        below = np.minimum(places.astype(np.int64), len(self._received) - 2)
        received = np.stack(self._received)
        share = (places - below)[:, None]
        late = (1 - share) * received[below] + share * received[below + 1]
        drive = self.robot.drive
        reached = self._filter.next(late) + self._advance_program()
        reference = np.vstack([self._reference[-1:], drive.motor_angle(reached)])
        speed = np.vstack([self._rates[-1:], np.diff(reference, axis=0) / self._step])
        self._rates, before = speed, self._rates
        self._acceleration = (speed[-1] - before[-1]) / self.cycle
        return reference, speed

    def _advance_program(self) -> Array:
        """Run the controller's own program for a cycle; returns its positions at the physics steps, link side."""
        if self._program is None:
            return np.zeros(self.robot.n_joints)
        k = min(self._run_cycles, len(self._program) - 1)
        following = min(k + 1, len(self._program) - 1) if self.runs else k
        self._run_cycles = following
        share = (np.arange(1, self._substeps + 1) / self._substeps)[:, None]
        return (1 - share) * self._program[k] + share * self._program[following]

    def _torques(self, reference: Array, speed: Array) -> Array:
        """Compute the rigid feed-forward at the physics steps of a cycle, motor side [N m], straight over the cycle."""
        before = self._feedforward
        if self._arm is not None:
            drive = self.robot.drive
            q, dq, ddq = (drive.joint_angle(x)[None] for x in (reference[-1], speed[-1], self._acceleration))
            links = self._arm.inverse_dynamics(q, dq, ddq)[0]
            self._feedforward = drive.motor_torque(links) + drive.rotor_inertia * self._acceleration
        share = (np.arange(self._substeps) / self._substeps)[:, None]
        return (1 - share) * before + share * self._feedforward

    def _note(self, reference: Array, states: tuple[Array, Array, Array]) -> None:
        speed = self._rates[1:]
        qpos, qvel, act = (part[0].copy() for part in states)
        self._rows.append((reference, speed, qpos, qvel, act))


class _StreamingFilter:
    """Filter of a controller, fed piece by piece; as `SetpointResponse.filter` does at once."""

    def __init__(self, response: SetpointResponse, dt: float, start: Array) -> None:
        self._start = start
        self._coefficients = response.discretise(dt)
        _, a = self._coefficients
        self._memory = np.zeros((len(a) - 1, len(start)))

    def next(self, values: Array) -> Array:
        """Filter the next values (S, N)."""
        b, a = self._coefficients
        filtered, self._memory = signal.lfilter(b, a, values - self._start, axis=0, zi=self._memory)
        return np.asarray(filtered) + self._start

"""Robot of an emulator: a simulated machine behind a controller.

The rigid feed-forward of the controller is that of `ffgym.control.rigid_feedforward`, computed from the reference that
the controller itself makes.
"""

from dataclasses import replace
from typing import final, get_args

import numpy as np
import scipy

from ffgym.control import SetpointResponse
from ffgym.control.setpoints import servo_torque
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array, IntArray
from ffgym.deployment.planning import FeedForward
from ffgym.deployment.streams.emulators.reference import ControllerReference, Missing
from ffgym.deployment.streams.recording import header_of
from ffgym.paths import Reference
from ffgym.recordings import Phase, Recording, clip_phases
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation.plant import Machine, Plant
from ffgym.simulation.plant.engine_state import PlantState


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
        feedforward: FeedForward = "setpoints",
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
            feedforward: what the controller computes its rigid feed-forward from: from all of the set-points, from
                its own program alone, or not at all. A controller that gets positions cannot tell corrections from
                the program, so that theirs comes on top of what the servo makes of them.
            missing: what it does in a cycle without a set-point.
            program: joint positions at each cycle of a program that the controller runs by itself, link side, shape
                (T, N), which begins at `start`; set-points are then corrections of it, and they alone are delayed and
                filtered. None takes positions.
            options: what to leave out of the plant, or another physics step.

        Raises:
            FFGymError: if times do not fit.
        """
        check_choice("feed-forward of a controller", feedforward, get_args(FeedForward))
        if feedforward == "program" and program is None:
            raise FFGymError(
                "Feed-forward of the program alone needs a controller that runs it and gets corrections; choose "
                "'setpoints' or 'none'."
            )
        self.plant = Plant(machine, 1, options=options, n_threads=1)
        self.robot, self.cycle, self.response = self.plant.robot, cycle, response
        self._step = self.plant.physics_dt
        self._reference = ControllerReference(
            self.robot.drive,
            start,
            cycle=cycle,
            step=self._step,
            response=response,
            missing=missing,
            program=program,
        )
        self._arm, self._source, self._delays_all = arm or RigidArm(self.robot), feedforward, program is None
        self._feedforward = np.zeros(len(start))
        self.plant.rest(start[None])
        self._rows: list[tuple[Array, Array, Array, Array, Array, Array]] = []
        self.runs = False
        """True while the controller runs its own program; set it to begin."""
        self.cycles = 0
        """Cycles so far."""
        self.missed = 0
        """Cycles without a set-point."""
        self.began: float | None = None
        """Time of the first set-point, or of the beginning of the controller's own program [s]; None before it."""

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
        return self.robot.drive.joint_angle(self._reference.position[-1])

    @property
    def has_ended(self) -> bool:
        """True once the controller has come to the end of its program."""
        return self._reference.has_ended

    def advance(self, setpoint: Array | None, torque: Array | None = None) -> None:
        """Simulate a cycle.

        Args:
            setpoint: set-point that came at its beginning, link side [rad or m], shape (N,); None if none came.
            torque: torque to add over the whole cycle, motor side [N m], shape (N,).

        Raises:
            FFGymError: if the robot becomes unstable.
        """
        self.missed += setpoint is None
        if self.began is None and (setpoint is not None if self._delays_all else self.runs):
            self.began = self.time
        self._reference.advance(setpoint, self.runs)
        position, speed = self._reference.position, self._reference.speed
        controls = np.empty((1, len(position) - 1, 3 * self.robot.n_joints))
        positions, speeds, torques = self.plant.split_controls(controls)
        positions[0], speeds[0] = position[:-1], speed[:-1]
        added = self._rigid_torques() + (0.0 if torque is None else torque)
        torques[0] = added[:-1]
        qpos, qvel, act = (part[0].copy() for part in self.plant.advance(controls))
        self._rows.append((position[1:], speed[1:], added[1:], qpos, qvel, act))
        self.cycles += 1

    def _rigid_torques(self) -> Array:
        """Compute the rigid feed-forward at the steps of a cycle and its end, motor side [N m], (S + 1, N)."""
        before, reference = self._feedforward, self._reference
        if self._source != "none":
            drive = self.robot.drive
            change = reference.own_change + (reference.change if self._source == "setpoints" else 0.0)
            q, dq = (drive.joint_angle(values[-1:]) for values in (reference.position, reference.speed))
            links = self._arm.inverse_dynamics(q, dq, change[None])[0]
            self._feedforward = drive.motor_torque(links) + drive.rotor_inertia * drive.motor_angle(change)
        steps = len(reference.position) - 1
        share = (np.arange(steps + 1) / steps)[:, None]
        torques: Array = (1 - share) * before + share * self._feedforward
        return torques

    def truth(self, segment: str, reference: Reference | None = None) -> Recording:
        """Make the recording of all cycles so far, with the true states, at every physics step.

        Times count from the start of the robot. `reference.*` is what the servo tracked.

        Args:
            segment: name of the motion.
            reference: motion that was meant; the recording then has its phases and its tool path, as late as the
                controller was, so that path errors can be computed.

        Raises:
            FFGymError: if the robot has not moved yet.
        """
        if not self._rows:
            raise FFGymError("The robot has not moved yet; run it before its truth is asked for.")
        position, speed, added, qpos, qvel, act = (np.concatenate(part) for part in zip(*self._rows, strict=True))
        state = self.plant.unpack(qpos, qvel, act)
        families = {
            "reference.position": position,
            "reference.velocity": speed,
            "motor.position": state.motor_position,
            "motor.velocity": state.motor_velocity,
            "motor.effort": self._motor_torque(position, speed, added, state),
            "link.position": state.link_position,
            "link.velocity": state.link_velocity,
        }
        joints, t = self.robot.joints, np.arange(1, len(qpos) + 1, dtype=np.float64) * self._step
        columns: dict[str, Array] = {"timestamp": t}
        columns |= {f"{name}.{joint}": x[:, j] for name, x in families.items() for j, joint in enumerate(joints)}
        phases: tuple[Phase, ...] = ()
        if self.robot.tool is not None:
            moved = self.plant.tcp_position(0, qpos)
            tcp = {"tcp.position": self._arm.tcp_position(state.link_position) if moved is None else moved}
            if reference is not None:
                meant, phases = self._delay(reference, t)
                tcp["tcp_reference.position"] = self._arm.tcp_position(meant)
            columns |= {f"{name}.{axis}": xyz[:, k] for name, xyz in tcp.items() for k, axis in enumerate("xyz")}
        provenance = {
            "simulated": True,
            "physics_fingerprint": self.plant.fingerprint(),
            "physics_dt": self._step,
        }
        header = header_of(self.robot, segment, provenance=provenance)
        header = replace(header, phases=phases, torque_semantics="motor_side", hold="sampled")
        return Recording(columns=columns, header=header)

    def torque_at(self, cycles: IntArray) -> Array:
        """Return the motor torque at the beginning of cycles that are done, or at the end of the last, (K, N) [N m].

        At the beginning of the first cycle it is that of the first step.
        """
        position, speed, added, qpos, qvel, act = (np.concatenate(part) for part in zip(*self._rows, strict=True))
        rows = np.maximum(cycles * round(self.cycle / self._step) - 1, 0)
        state = self.plant.unpack(qpos[rows], qvel[rows], act[rows])
        return self._motor_torque(position[rows], speed[rows], added[rows], state)

    def _motor_torque(self, position: Array, speed: Array, added: Array, state: PlantState) -> Array:
        """Compute the torque that the servos ask of the motors, within their limits, motor side [N m], shape (T, N)."""
        machine = self.plant.machines[0]
        servo, peak = machine.physical.servo, machine.physical.drive.peak_torque
        angle, rate = machine.read_by_resolver(state.motor_position, state.motor_velocity)
        feedback = servo_torque(servo, position - angle, speed - rate, state.integral)
        return np.clip(feedback.u_fb + added, -peak, peak)

    def _delay(self, reference: Reference, t: Array) -> tuple[Array, tuple[Phase, ...]]:
        """Sample a motion that was meant at times `t` [s] of the robot, as late as the controller is, link side."""
        if self.began is None:
            raise FFGymError("No set-point came; there is nothing to compare with what was meant.")
        late = self.began + (self.response.total_delay if self._delays_all else 0.0)
        places = np.clip(t - late, 0.0, reference.t[-1])
        phases = [replace(phase, start=phase.start + late, end=phase.end + late) for phase in reference.phases]
        meant = np.asarray(
            scipy.interpolate.make_interp_spline(reference.t, reference.q, k=3)(places), dtype=np.float64
        )
        return meant, clip_phases(phases, float(t[0]), float(t[-1]))

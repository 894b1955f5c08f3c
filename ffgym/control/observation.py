"""Observation of an agent: layout and physical scales of its entries."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from ffgym.control.corrections import check_invertible
from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.types import Array
from ffgym.robot import RobotDescription

Channel: TypeAlias = Literal["torque", "setpoint"]
"""Quantity to which actions are added: torque of each motor, or position that its servo follows."""
CHANNELS: tuple[Channel, ...] = get_args(Channel)
BOUND = 100.0
"""Limit to which scaled observations are clipped; a robot in order stays far below it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ObservationEntry:
    """Quantity of an observation, one number per joint."""

    slice: slice
    """Slice of the observation with its N numbers."""
    unit: str
    side: Literal["motor", "link"]
    scale: Array
    """Physical value = observation * scale, shape (N,)."""
    meaning: str


TENTHS = 0.1
"""Unit of errors beside features, in f_s / K: errors under a law that knows its robot are tenths of it."""


class ObservationLayout(Mapping[str, ObservationEntry]):
    """Entries of an observation by name; `read` gives physical values without counting of indices.

    Sample 0 of the reference is now; `reference_velocity` is sample 0, `reference_velocity_1` the one after it, and so
    on up to `preview`. An action sets the torque that is reached at sample 1.

    Args:
        robot: robot of the controller.
        preview: samples of the reference after the present one.
        action_size: what an action of 1 adds, motor side: torque [N m], or position of the set-point [rad], shape (N,).
        channel: quantity that an action is added to.
        sees_errors: False leaves out the errors of the motors, as the track feed-forward does.
        features: True adds the torque of the base at the next sample and the direction of each sample of the reference,
            and counts errors in tenths.
    """

    def __init__(
        self,
        robot: RobotDescription,
        preview: int,
        action_size: Array,
        *,
        channel: Channel = "torque",
        sees_errors: bool = True,
        features: bool = False,
    ) -> None:
        self.preview = check_whole("preview", preview, low=0, high=1000)
        self.n_joints = n = robot.n_joints
        self.sees_errors, self.features = sees_errors, features
        self.channel, self.servo = channel, robot.servo
        self._drive, scales = robot.drive, Scales.of(robot)
        # scale of each entry: tracking error, its rate, last action, then the reference over the preview
        motor_position = scales.position * robot.drive.gear_ratio  # with its sign, as joint positions are read
        length = " or ".join(dict.fromkeys(robot.kinematics.units))
        reference = np.concatenate([motor_position, scales.velocity, scales.acceleration])
        unit = TENTHS if features else 1.0
        errors = {"error": unit * scales.error, "error_rate": unit * scales.error_rate}
        self._stribeck_velocity = robot.friction.stribeck_velocity
        base = robot.friction.static if channel == "torque" else scales.error
        before = [*(errors.values() if sees_errors else ()), np.ones(n), *([base] if features else [])]
        self._scale = np.concatenate(before)
        self._tiled: dict[int, tuple[Array, Array, Array]] = {}
        self._sample_scale = np.concatenate([reference, np.ones(n if features else 0)])
        # catalogue of entries by name, in the order of the vector
        self._entries: dict[str, ObservationEntry] = {}

        def add(name: str, unit: str, scale: Array, meaning: str, side: Literal["motor", "link"] = "motor") -> None:
            start = len(self._entries) * n
            self._entries[name] = ObservationEntry(
                slice=slice(start, start + n), unit=unit, side=side, scale=scale, meaning=meaning
            )

        beyond = ", beyond what the base asks for" if features else ""
        if sees_errors:
            add("error", "rad", errors["error"], f"position error, reference - measured{beyond}")
            add("error_rate", "rad/s", errors["error_rate"], f"speed error, reference - measured{beyond}")
        added = f"added_{channel}"
        if channel == "torque":
            add(added, "N m", action_size, "added torque now: the last action")
        else:
            add(added, "rad", action_size, "correction of the set-point now: the last action")
        if features:
            add(
                f"base_{channel}",
                "N m" if channel == "torque" else "rad",
                base,
                f"{channel} of the base law one control step ahead",
            )
        # reference now and ahead, which lets a policy act before an error shows
        for k in range(self.preview + 1):
            when = "now" if k == 0 else f"{k} control step{'s' if k > 1 else ''} ahead"
            add(
                ahead("reference_position", k),
                length,
                scales.position,
                f"joint position of the reference, {when}",
                "link",
            )
            add(ahead("reference_velocity", k), "rad/s", scales.velocity, f"motor speed of the reference, {when}")
            add(ahead("reference_acceleration", k), "rad/s^2", scales.acceleration, f"motor acceleration of it, {when}")
            if features:
                meaning = f"tanh of the motor speed of the reference in Stribeck velocities, {when}"
                add(ahead("reference_direction", k), "1", np.ones(n), meaning)

    def __getitem__(self, name: str) -> ObservationEntry:
        return self._entries[check_choice("observation entry", name, list(self._entries))]

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def action_size(self) -> Array:
        """Size of an action of 1, motor side: torque [N m], or position of the set-point [rad], shape (N,)."""
        return self._entries[f"added_{self.channel}"].scale

    @property
    def size(self) -> int:
        """Length of an observation."""
        return len(self._entries) * self.n_joints

    @property
    def sample_size(self) -> int:
        """Length of a sample of the reference within an observation."""
        return len(self._sample_scale)

    def encode_samples(self, reference: Array) -> Array:
        """Encode samples of the reference, as they stand in observations: scaled and clipped, shape (T, K).

        Args:
            reference: position [rad], velocity, acceleration, motor side, shape (T, 3 N). Observed is the position of
                the joint times its own gear ratio, by which laws divide, without parts of coupled joints.
        """
        n = self.n_joints
        if self._drive.coupling is not None:
            position = self._drive.joint_angle(reference[:, :n]) * self._drive.gear_ratio
            reference = np.concatenate((position, reference[:, n:]), axis=1)
        if self.features:
            direction = np.tanh(reference[:, n : 2 * n] / self._stribeck_velocity)
            reference = np.concatenate((reference, direction), axis=1)
        return _clip(reference / self._sample_scale)

    def encode(
        self, error: Array, error_rate: Array, action: Array, samples: Array, base: Array | None = None
    ) -> Array:
        """Encode observations (B, D): scaled and clipped.

        Args:
            error: measured position error, motor side [rad], shape (B, N).
            error_rate: measured speed error, motor side [rad/s], shape (B, N).
            action: last action, shape (B, N).
            samples: reference, samples 0 to `preview` as `encode_samples` returns them, shape (B, P + 1, K).
            base: torque [N m] or set-point [rad] of the base at sample 1, motor side, shape (B, N); for features alone.
        """
        before = (error, error_rate, action) if self.sees_errors else (action,)
        if self.features:
            assert base is not None  # an environment with features has the torque of its base
            before = (*before, base)
        own = np.concatenate(before, axis=1)
        scale, low, high = self._tile(len(own))
        own /= scale
        _clip(own, low, high)
        return np.concatenate((own, samples.reshape(len(own), -1)), axis=1)

    def _tile(self, n: int) -> tuple[Array, Array, Array]:
        """Return scale and bounds with a row for each of `n` observations: arrays of one shape are divided faster."""
        found = self._tiled.get(n)
        if found is None:
            scale = np.tile(self._scale, (n, 1))
            self._tiled[n] = found = scale, np.full_like(scale, -BOUND), np.full_like(scale, BOUND)
        return found

    def read(self, observation: Array, name: str, ahead_by: int = 0) -> Array:
        """Read physical values (..., N) of an entry from observations (..., D), `ahead_by` samples ahead."""
        entry = self[ahead(name, ahead_by)]
        return np.asarray(observation, dtype=np.float64)[..., entry.slice] * entry.scale


def _clip(values: Array, low: float | Array = -BOUND, high: float | Array = BOUND) -> Array:
    """Clip scaled values to the bounds of observations, in place."""
    np.maximum(values, low, out=values)
    return np.minimum(values, high, out=values)


def ahead(name: str, samples: int) -> str:
    """Return the name of a reference entry some samples ahead."""
    return name if samples == 0 else f"{name}_{samples}"


@dataclass(frozen=True, kw_only=True, eq=False)
class Scales:
    """Fixed scales of observed quantities, per joint: each is the size that goes with the breakaway torque f_s."""

    error: Array
    """Error at which the proportional part gives f_s: f_s / K_p, motor side [rad]."""
    error_rate: Array
    """Speed error at which the derivative part gives f_s: f_s / K_v, motor side [rad/s]."""
    velocity: Array
    """Speed at which viscous friction is f_s: f_s / f_v, motor side [rad/s]."""
    acceleration: Array
    """Acceleration that f_s gives the bare rotor: f_s / J_m, motor side [rad/s^2]."""
    position: Array
    """Half a turn, link side [rad]; for a sliding joint half of its range [m]."""

    @classmethod
    def of(cls, robot: RobotDescription) -> "Scales":
        """Compute the scales of a robot."""
        breakaway = robot.friction.static
        divisors = {
            "error": ("servo.position_gain", robot.servo.position_gain),
            "error_rate": ("servo.velocity_gain", robot.servo.velocity_gain),
            "velocity": ("friction.viscous", robot.friction.viscous),
            "acceleration": ("drive.rotor_inertia", robot.drive.rotor_inertia),
        }
        for name, values in divisors.values():
            if np.any(values <= 0):
                raise FFGymError(
                    f"{name} = {values} of robot {robot.name!r} must be > 0 on every joint: observations are scaled by "
                    f"breakaway torque / {name}."
                )
        return cls(
            position=np.where(robot.kinematics.is_sliding, np.ptp(robot.kinematics.range, axis=1) / 2, np.pi),
            **{key: breakaway / values for key, (_, values) in divisors.items()},
        )


def size_actions(robot: RobotDescription, scale: float | Array, channel: Channel) -> Array:
    """Compute what an action of 1 adds, motor side: torque [N m], or position of the set-point [rad], shape (N,).

    Args:
        robot: robot of the controller.
        scale: torque in breakaway torques f_s of each joint; of set-points, position in f_s / K_p.
        channel: quantity that an action is added to.

    Raises:
        FFGymError: if the servo does not take corrections of set-points.
    """
    torque: Array = scale * robot.friction.static
    if channel == "torque":
        return torque
    check_invertible(robot.servo)
    return torque / robot.servo.position_gain

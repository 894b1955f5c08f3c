"""A state of simulations whose fields are computed when they are asked for."""

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.effects import State
from ffgym.robot.drive import Drive
from ffgym.simulation.plant.addresses import Addresses
from ffgym.simulation.plant.numbers import Numbers


class Reading(State):
    """What the engine had at one instant, (B, N) each: effects need few fields, at every physics step."""

    __slots__ = ("_act", "_at", "_controls", "_drive", "_own", "_passed", "_qpos", "_qvel")

    def __init__(
        self,
        at: Addresses,
        drive: Drive,
        own: Numbers,
        *,
        qpos: Array,
        qvel: Array,
        act: Array,
        controls: Array,
        time: Array,
        passed: Array | None = None,
    ) -> None:
        self._at, self._drive, self._own = at, drive, own
        self._qpos, self._qvel, self._act, self._controls = qpos, qvel, act, controls
        self._passed = passed
        self.time = time

    def __getattr__(self, name: str) -> Array:
        """A field that nobody has asked for yet; called by Python where a slot is empty."""
        compute = getattr(type(self), f"_{name}_now", None)
        if compute is not None:
            value: Array = compute(self)
        elif name in State.__slots__:
            value = getattr(self._own, name)
        else:
            raise AttributeError(f"A state has no {name}.")
        setattr(self, name, value)
        return value

    def _running_now(self) -> Array:
        return self._own.running_since + self.time

    def _temperature_now(self) -> Array:
        return self._own.temperature(self.time)

    def _joint_angle_now(self) -> Array:
        return self._qpos[:, self._at.motor_qpos]

    def _joint_speed_now(self) -> Array:
        return self._qvel[:, self._at.motor_qpos]

    def _motor_angle_now(self) -> Array:
        return self._drive.motor_angle(self.joint_angle)

    def _motor_speed_now(self) -> Array:
        return self._drive.motor_angle(self.joint_speed)

    def _deflection_now(self) -> Array:
        return _spread(self._qpos, self._at.deflection_qpos, self._at.is_elastic)

    def _deflection_rate_now(self) -> Array:
        return _spread(self._qvel, self._at.deflection_qpos, self._at.is_elastic)

    def _joint_stiffness_now(self) -> Array:
        return self._own.stiffness

    def _joint_damping_now(self) -> Array:
        return self._own.damping

    def _load_now(self) -> Array:
        load: Array = -(self._own.stiffness * self.deflection + self._own.damping * self.deflection_rate)
        return load if self._passed is None else np.where(self._at.is_elastic, load, self._passed)

    def _load_at_motor_now(self) -> Array:
        return self._drive.motor_torque(self.load)

    def _friction_sign_now(self) -> Array:
        own, at = self._own, self._at
        bristle = _spread(self._act, at.bristle[at.has_bristle], at.has_bristle)
        level = own.coulomb + (own.static - own.coulomb) * np.exp(-((self.motor_speed / own.stribeck_velocity) ** 2))
        sign: Array = own.bristle_stiffness * bristle / level
        return sign

    def _feedback_torque_now(self) -> Array:
        """What MuJoCo's `pid` computes in the coming step, motor side [N m]."""
        own, at, controls = self._own, self._at, self._controls
        integral = _spread(self._act, at.integral[at.has_integral], at.has_integral)
        end = 3 * integral.shape[1]
        feedback: Array = (
            own.position_gain * (controls[:, 0:end:3] - self.motor_angle)
            + own.velocity_gain * (controls[:, 1:end:3] - self.motor_speed)
            + own.integral_gain * integral
        )
        return feedback

    def _motor_torque_now(self) -> Array:
        """The same with the feed-forward, as far as the drive gives it."""
        peak = self._own.peak_torque
        total = self.feedback_torque + self._controls[:, 2 : 3 * peak.shape[1] : 3]
        return np.minimum(np.maximum(total, -peak), peak)


def _spread(values: Array, places: IntArray, where: BoolArray) -> Array:
    """What stands at `places`, of the joints `where`, 0 for the others, (B, N)."""
    found = values[:, places]
    if found.shape[1] == len(where):
        return found
    spread = np.zeros((len(found), len(where)))
    spread[:, where] = found
    return spread

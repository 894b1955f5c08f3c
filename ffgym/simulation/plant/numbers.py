"""Numbers of many machines side by side, of which states are made."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.robot.friction import LuGreParameters
from ffgym.simulation.plant.machine import Climate, Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Numbers:
    """Numbers of B machines that states are made of, (B, N) each, or (B, 1)."""

    stiffness: Array
    damping: Array
    reflected_inertia: Array
    """Of the rotors behind the gearbox [kg m^2]."""
    position_gain: Array
    velocity_gain: Array
    integral_gain: Array
    peak_torque: Array
    coulomb: Array
    static: Array
    viscous: Array
    stribeck_velocity: Array
    bristle_stiffness: Array
    ambient: Array
    rise: Array
    time_constant: Array
    running_since: Array

    @classmethod
    def of(cls, machines: Sequence[Machine], n: int) -> "Numbers":
        """Numbers of machines of `n` joints."""
        robots, climates = [m.physical for m in machines], [m.climate or Climate() for m in machines]

        def per_joint(part: str, name: str) -> Array:
            return np.stack([getattr(getattr(robot, part), name) for robot in robots])

        def of_climate(name: str) -> Array:
            return np.array([[getattr(climate, name)] for climate in climates], dtype=np.float64)

        stiffness = per_joint("drive", "joint_stiffness")
        friction: dict[str, Any] = {
            f.name: per_joint("friction", f.name)
            for f in fields(LuGreParameters)
            if f.name in {g.name for g in fields(cls)}
        }
        return cls(
            stiffness=np.where(np.isinf(stiffness), 0.0, stiffness),  # a rigid joint has no deflection either
            damping=np.where(np.isinf(stiffness), 0.0, per_joint("drive", "joint_damping")),
            reflected_inertia=per_joint("drive", "gear_ratio") ** 2 * per_joint("drive", "rotor_inertia"),
            position_gain=per_joint("servo", "position_gain"),
            velocity_gain=per_joint("servo", "velocity_gain"),
            integral_gain=per_joint("servo", "integral_gain"),
            peak_torque=per_joint("drive", "peak_torque"),
            **friction,
            ambient=of_climate("ambient"),
            rise=np.stack([np.broadcast_to(climate.rise, (n,)) for climate in climates]),
            time_constant=of_climate("time_constant"),
            running_since=of_climate("running_since"),
        )

    def rows(self, rows: IntArray | slice) -> "Numbers":
        """Numbers of some of the machines."""
        if isinstance(rows, slice):
            return self
        return type(self)(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    def temperature(self, time: Array) -> Array:
        """[degC], (B, N), at times [s] (B, 1) since the motion began; see `Climate`."""
        warm = -np.expm1(-(self.running_since + time) / self.time_constant)
        return self.ambient + self.rise * warm

"""A second arm that shares only the description with ffgym: homogeneous transforms, energies, Lagrange's equations.

Everything accepts complex angles, so that first derivatives come without rounding from the complex step.
"""

import numpy as np

from ffgym.robot import RobotDescription

_STEP = 1e-30
"""Complex step: far below rounding, so that the derivative is exact."""


class IndependentArm:
    """Kinetic and potential energy of a serial arm [J], link side, one pose at a time: q, dq have shape (N,)."""

    def __init__(self, robot: RobotDescription) -> None:
        self.robot = robot
        self.slides = robot.kinematics.is_sliding
        self.loads = [
            [(mass, com, _tensor(inertia))]
            for mass, com, inertia in zip(robot.bodies.mass, robot.bodies.com, robot.bodies.inertia, strict=True)
        ]
        if robot.tool is not None:
            turn, tool = robot.tool.rotation, robot.tool
            com = tool.position + turn @ tool.com
            self.loads[-1].append((tool.mass, com, turn @ _tensor(tool.inertia) @ turn.T))

    def frames(self, q):
        """Homogeneous transforms of all link frames, (N, 4, 4)."""
        frame, frames = np.eye(4, dtype=np.result_type(q, float)), []
        for i in range(len(q)):
            frame = frame @ self._step(i, q[i])
            frames.append(frame)
        return np.array(frames)

    def frame_rates(self, q, dq):
        """Time derivative of all link frames, (N, 4, 4), by the product rule along the chain."""
        frame, rate = np.eye(4, dtype=np.result_type(q, dq, float)), np.zeros((4, 4), np.result_type(q, dq, float))
        rates = []
        for i in range(len(q)):
            step = self._step(i, q[i])
            frame, rate = frame @ step, rate @ step + frame @ self._step_rate(i, q[i], dq[i])
            rates.append(rate)
        return np.array(rates)

    def _step(self, i, value):
        """From the frame of link i - 1 to that of link i."""
        axis = self.robot.kinematics.axis[i]
        step = np.eye(4, dtype=np.result_type(value, float))
        step[:3, 3] = self.robot.kinematics.position[i]
        if self.slides[i]:
            step[:3, 3] += value * axis
        else:
            cross = _skew(axis)
            step[:3, :3] = np.eye(3) + np.sin(value) * cross + (1 - np.cos(value)) * cross @ cross
        return step

    def _step_rate(self, i, value, speed):
        """Time derivative of the above."""
        axis = self.robot.kinematics.axis[i]
        rate = np.zeros((4, 4), dtype=np.result_type(value, speed, float))
        if self.slides[i]:
            rate[:3, 3] = speed * axis
        else:
            cross = _skew(axis)
            rate[:3, :3] = speed * (np.cos(value) * cross + np.sin(value) * cross @ cross)
        return rate

    def tcp(self, q):
        """TCP in the world [m]."""
        tool = self.robot.tool
        return (self.frames(q)[-1] @ np.append(tool.position + tool.rotation @ tool.tcp, 1.0))[:3]

    def tool_rotation(self, q):
        """Orientation of tool0 in the world."""
        return self.frames(q)[-1][:3, :3] @ self.robot.tool.rotation

    def kinetic_energy(self, q, dq):
        """Sum of m v^2 / 2 + trace(dR S dR^T) / 2, with S the second moment of mass about the centre of mass."""
        energy = 0.0
        for rate, loads in zip(self.frame_rates(q, dq), self.loads, strict=True):
            for mass, com, inertia in loads:
                velocity = rate[:3, :3] @ com + rate[:3, 3]
                moment = 0.5 * np.trace(inertia) * np.eye(3) - inertia
                energy = energy + 0.5 * mass * velocity @ velocity
                energy = energy + 0.5 * np.trace(rate[:3, :3] @ moment @ rate[:3, :3].T)
        return energy

    def potential_energy(self, q):
        """Sum of -m g.p over all bodies."""
        energy = 0.0
        for frame, loads in zip(self.frames(q), self.loads, strict=True):
            for mass, com, _ in loads:
                energy = energy - mass * self.robot.gravity @ (frame[:3, :3] @ com + frame[:3, 3])
        return energy

    def momentum(self, q, dq):
        """Momentum dT/d dq by the complex step, (N,)."""
        return _gradient(lambda x: self.kinetic_energy(q, x), dq)

    def gravity_torque(self, q):
        """Slope of the potential energy, dV/dq, by the complex step, (N,)."""
        return _gradient(self.potential_energy, q)

    def mass_matrix(self, q):
        """Column j is the momentum at unit speed of joint j."""
        return np.array([self.momentum(q, unit) for unit in np.eye(len(q))])

    def lagrange_torque(self, q, dq, ddq, step=1e-4):
        """Lagrange: d/dt (dT/d dq) - dT/dq, without gravity; d/dt by central differences along the motion."""

        def momentum_at(t):
            return self.momentum(q + dq * t + 0.5 * ddq * t * t, dq + ddq * t)

        change = (8 * (momentum_at(step) - momentum_at(-step)) - momentum_at(2 * step) + momentum_at(-2 * step)) / 12
        return change / step - _gradient(lambda x: self.kinetic_energy(x, dq), q)


def _gradient(energy, x):
    """Derivative of a real function by the complex step, (N,)."""
    return np.array([energy(x + 1j * _STEP * unit).imag / _STEP for unit in np.eye(len(x))])


def _skew(axis):
    x, y, z = axis
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _tensor(inertia):
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

r"""The independent plant: motors, gearboxes, springs and arm, integrated by the classical Runge-Kutta method.

.. math::
    M \ddot q + b = \tau_s, \quad J \ddot \theta = u - \tau_f - \tau_s\, \partial q / \partial \theta, \quad
    \tau_s = -k\, (q - \theta / n) - d\, (\dot q - \dot \theta / n)

Motors of rigid joints move with the arm, and their rotors add :math:`n^2 J` to its mass matrix. Friction that is hidden
behind springs yields along the way of the link (Dahl 1968), with the strength
:math:`g = g_c + (g_b - g_c) / (1 + |v| / v_s)`.
"""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from scripts.exam.independent.arm import mass_and_bias
from scripts.exam.independent.drive import Contact, Orders, Servo
from scripts.exam.independent.machine import Numbers

_EDGE = 0.1
"""Width over which the edges of play are round, as a share of half the play."""

_WARM = 15.0
"""Warming at which half of what warmth takes of viscous friction is gone [K]."""

_SLOW = 0.01
"""Share of the usual speed below which bent viscous friction is linear."""

_SAGGING = 4
"""Times that the sag of springs under gravity is improved; it changes gravity by some thousandths."""

_FAR = 1e6
"""Motor angle [rad] at which a run has surely become unstable."""

Stage = tuple[Array, Array]
"""Rates of the state, (6, B, N), and torque of the servo."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Course:
    """States and torques at every recorded row; shape (T, B, N) each."""

    q: Array
    """Behind springs [rad]."""
    dq: Array
    angle: Array
    """Angle of the motors, as their resolvers read it [rad]."""
    speed: Array
    """Rate of that angle [rad/s]."""
    torque: Array
    """Torque of the motors, as their currents say [N m]."""


class Plant:
    """Machines that follow their set-points; q, dq, angle, speed, servo and lagging torque are rows of the state."""

    def __init__(
        self, numbers: Numbers, contact: Contact, servo: Servo, *, dt: float, clock: Array, warming: Array
    ) -> None:
        """Make a plant.

        Args:
            numbers: machines.
            contact: friction of their motors.
            servo: what drives them.
            dt: step [s].
            clock: time of day at which each motion begins [s], shape (B,).
            warming: of the joints beyond what their descriptions hold for [K], shape (B, N).
        """
        self.numbers, self.contact, self.servo, self.dt = numbers, contact, servo, dt
        self._clock, self._warming = clock[:, None], warming
        self._faults = {name: values for name, values in numbers.faults.items() if np.any(values)}
        self._load = np.zeros(numbers.shape)
        self._start = np.zeros(numbers.shape)
        rotors = np.where(numbers.rigid, numbers.gear_ratio**2 * numbers.rotor, 0.0)
        self._rotors = rotors[..., None] * np.eye(numbers.shape[1])
        self._all_rigid, self._any_rigid = bool(numbers.rigid.all()), bool(numbers.rigid.any())
        self._lever = 1 / numbers.gear_ratio
        self._behind = Contact(stiffness=contact.stiffness, has_blocks=np.zeros(numbers.shape, dtype=np.bool_))

    def run(self, q: Array, orders: Orders, every: int) -> Course:
        """Follow `orders` from rest at `q` (B, N), and record every so many steps.

        Raises:
            FFGymError: if the motion becomes unstable.
        """
        state = self._at_rest(q, orders)
        steps = (len(orders.position) - 1) // 2
        rows = []
        for k in range(steps + 1):
            self.servo.sample(k, orders, self._seen(state[2]))
            self._start, self._link_start = state[2], state[0]
            first = self.rates(state, 2 * k, orders)
            if k % every == 0:
                error = self._faults.get("resolver")
                speed = state[3] if error is None else state[3] * (1 + error * np.cos(state[2]))
                read = self._seen(state[2]), speed
                rows.append(np.stack([*state[:2], *read, first[1] + orders.ahead[2 * k]]))
                if not np.all(np.abs(state[2]) < _FAR):
                    raise FFGymError(f"The independent plant became unstable at {k * self.dt:.3f} s; soften its servo.")
            if k < steps:
                state = self._step(state, 2 * k, orders, first[0])
        done = np.stack(rows, axis=1)
        return Course(q=done[0], dq=done[1], angle=done[2], speed=done[3], torque=done[4])

    def _at_rest(self, q: Array, orders: Orders) -> Array:
        """State in which motors hold the arm; springs bend as they are described."""
        n = self.numbers
        still, angle, link = np.zeros_like(q), q * n.gear_ratio, q
        for _ in range(_SAGGING):
            _, holding = mass_and_bias(n.bodies, link, still)
            link = np.where(n.rigid, q, q - holding / np.where(n.rigid, 1.0, n.stiffness))
        beside = holding / n.gear_ratio - orders.ahead[0]
        away = np.sign(orders.position - orders.position[0])
        first = np.take_along_axis(away, np.argmax(away != 0, axis=0)[None], axis=0)[0]
        heading = np.where(first == 0, 1.0, first)
        self._memory = self.contact.at_rest(heading, n.breakaway)
        self._link_memory = self._behind.at_rest(heading, n.breakaway)
        self.servo.begin(self._seen(angle), beside, self.dt)
        self._load = holding
        return np.stack([link, still, angle, still, beside, holding / n.gear_ratio])

    def _step(self, state: Array, half: int, orders: Orders, first: Array) -> Array:
        h = self.dt
        second, _ = self.rates(state + h / 2 * first, half + 1, orders)
        third, _ = self.rates(state + h / 2 * second, half + 1, orders)
        fourth, _ = self.rates(state + h * third, half + 2, orders)
        after: Array = state + h / 6 * (first + 2 * (second + third) + fourth)
        strength = self._strength(after[0], after[2], after[3], half + 2)
        _, self._memory = self.contact.move(self._memory, after[2] - self._start, strength)
        if "behind" in self._faults:
            self._link_memory = self._rub_link(after[0], after[1])[1]
        return after

    def rates(self, state: Array, half: int, orders: Orders) -> Stage:
        """Rates of a state at a half step since the motion began, and torque of the servo beside the feed-forward."""
        n, f = self.numbers, self._faults
        q, dq, angle, speed, servo, lagging = state
        # the motor's torque
        feedback, servo_rate = self.servo.torque(servo, half, orders, self._seen(angle), speed)
        said = feedback + orders.ahead[half]
        late, lag_rate = said, lagging * 0.0
        if "lag" in f:
            late = np.where(f["lag"] > 0, lagging, said)
            lag_rate = (said - lagging) / np.where(f["lag"] > 0, f["lag"], 1.0)
        torque = self._given(late, angle) - self._friction(q, angle, speed, half)
        if "clock" in f:
            torque = torque + f["clock"] * np.tanh(4 * np.sin(2 * np.pi * f["frequency"] * self._time(half)))
        # spring and arm
        lever = self._lever
        if "tooth" in f:
            lever = lever + f["tooth"] * np.cos(angle)
        spring = np.zeros_like(q) if self._all_rigid else self._spring(q, dq, angle, speed, lever)
        matrix, bias = mass_and_bias(n.bodies, q, dq)
        driving = (np.where(n.rigid, n.gear_ratio * torque, spring) if self._any_rigid else spring) - bias
        if "behind" in f:
            driving = driving - f["behind"] * n.gear_ratio * self._rub_link(q, dq)[0]
        if "balance" in f:
            driving = driving - f["balance"] * np.cos(q)
        ddq = np.linalg.solve(matrix + self._rotors, driving[..., None])[..., 0]
        acceleration = (torque - spring * lever) / n.rotor
        if self._any_rigid:
            acceleration = np.where(n.rigid, n.gear_ratio * ddq, acceleration)
        if "load_share" in f:
            carried = (matrix @ ddq[..., None])[..., 0] + bias
            self._load = np.where(n.rigid, carried, spring)
        return np.array([dq, ddq, speed, acceleration, servo_rate, lag_rate]), feedback  # faster than np.stack

    def _seen(self, angle: Array) -> Array:
        """Angle as the resolver reads it."""
        return angle + self._faults["resolver"] * np.sin(angle) if "resolver" in self._faults else angle

    def _given(self, torque: Array, angle: Array) -> Array:
        """Torque of motors whose currents say `torque`."""
        f = self._faults
        given = torque
        if "torque_error" in f or "offset" in f:
            given = torque * (1 + f.get("torque_error", 0.0)) + f.get("offset", 0.0)
        if "ripple" in f:
            given = given + torque * f["ripple"] * np.sin(f["ripple_cycles"] * angle)
        if "cogging" in f:
            given = given + f["cogging"] * np.sin(f["cogging_cycles"] * angle)
        return given

    def _strength(self, q: Array, angle: Array, speed: Array, half: int) -> Array:
        """Compute the torque that the contact bears in the direction of the last movement [N m]."""
        n, f = self.numbers, self._faults
        level = n.coulomb + (n.breakaway - n.coulomb) * np.exp(-((speed / n.stribeck) ** 2))
        if "asymmetry" in f:
            way = angle - self._start
            level = level + f["asymmetry"] * n.coulomb * np.sign(np.where(way == 0, speed, way))
        if "load_share" in f:
            level = level + f["load_share"] * np.abs(self._load / n.gear_ratio)
        if "wear" in f:
            level = level + f["wear"] * n.coulomb * (self._time(half) / 3600.0)
        if "waves" in f:
            level = level + f["waves"] * n.coulomb * np.sin(f["wave_cycles"] * q)
        return level

    def _friction(self, q: Array, angle: Array, speed: Array, half: int) -> Array:
        n, f = self.numbers, self._faults
        strength = self._strength(q, angle, speed, half)
        contact = self.contact.move(self._memory, angle - self._start, strength)[0]
        yielding = np.minimum(np.maximum(1 - np.sign(speed) * contact / strength, 0.0), 2.0)  # faster than np.clip
        viscous = n.viscous * speed
        if "bend" in f:
            share = np.hypot(speed, _SLOW * n.usual_speed) / n.usual_speed
            viscous = viscous * share ** -f["bend"]
        if "warm" in f:
            viscous = viscous * (1 - f["warm"] * self._warming**2 / (self._warming**2 + _WARM**2))
        drag = contact + n.rubbing * speed * yielding + viscous
        if "brake" in f:
            drag = drag + f["brake"] * np.sin(2 * np.pi * f["frequency"] * self._time(half)) * contact / strength
        if "neighbour" in f:
            drag = drag + f["neighbour"] * np.sin(3.0 * np.roll(q, -1, axis=1))
        return drag * (1 - f["behind"]) if "behind" in f else drag

    def _rub_link(self, q: Array, dq: Array) -> tuple[Array, Array]:
        """Friction of links in units of their motors [N m], as if all of it were behind springs, and its memory."""
        n = self.numbers
        speed, way = n.gear_ratio * dq, n.gear_ratio * (q - self._link_start)
        strength = n.coulomb + (n.breakaway - n.coulomb) / (1 + np.abs(speed) / n.stribeck)
        contact, memory = self._behind.move(self._link_memory, way, strength)
        yielding = np.clip(1 - np.sign(speed) * contact / strength, 0.0, 2.0)
        return contact + n.rubbing * speed * yielding + n.viscous * speed, memory

    def _spring(self, q: Array, dq: Array, angle: Array, speed: Array, lever: Array) -> Array:
        """Torque of the springs on the links; 0 in rigid joints."""
        n, f = self.numbers, self._faults
        bent = q - angle * self._lever
        if "tooth" in f:
            bent = bent - f["tooth"] * np.sin(angle)
        if "gap" in f:
            gap = np.maximum(f["gap"], 1e-12)
            edge = _EDGE * gap
            inside = edge * (np.logaddexp(0, (bent - gap) / edge) - np.logaddexp(0, (-bent - gap) / edge))
            bent = np.where(f["gap"] > 0, inside, bent)
        if "growth" in f:
            bent = bent * (1 + f["growth"] * np.abs(bent) / np.where(f["growth_at"] > 0, f["growth_at"], 1.0))
        torque: Array = -n.stiffness * bent - n.damping * (dq - speed * lever)
        return np.where(n.rigid, 0.0, torque) if self._any_rigid else torque

    def _time(self, half: int) -> Array:
        return self._clock + half * self.dt / 2

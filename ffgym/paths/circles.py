"""The test motion of the thesis: circles around a common start point, each with lead-in and lead-out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape
from ffgym.core.types import Array
from ffgym.paths.motion import CartesianPath, Segment, sample, standstill

BLEND = 0.5
"""Share of the lead's length that is clothoid; chosen: half keeps the small circle visible."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, kw_only=True)
class HalfCircle:
    """Half a circle of half the radius, as in the thesis; its quantities are those of `SmoothLead`."""

    length: float = np.pi / 2

    def bend(self, s: Array) -> Array:
        """2 throughout."""
        return np.full_like(s, 2.0)

    def heading(self, s: Array) -> Array:
        """Lead from backwards to along x."""
        return 2.0 * (s - self.length)

    def point(self, s: Array) -> Array:
        """Lead on the circle around (0, 1/2)."""
        angle = self.heading(s)
        return np.stack([0.5 * np.sin(angle), 0.5 - 0.5 * np.cos(angle)], axis=1)


@dataclass(frozen=True, kw_only=True)
class SmoothLead:
    """Lead onto the unit circle around (0, 1), joined at the origin along x: a small circle, then a clothoid."""

    curvature: float
    """Curvature of the small circle, in units of 1 / r."""
    length: float
    """Arc length from the centre to the joint, in units of r."""

    @property
    def knot(self) -> float:
        """Arc length at which the clothoid begins."""
        return (1 - BLEND) * self.length

    def bend(self, s: Array) -> Array:
        """Curvature at arc length `s` from the centre, shape (T,)."""
        ramp = np.clip((s - self.knot) / (self.length - self.knot), 0.0, 1.0)
        return self.curvature + ramp * (1.0 - self.curvature)

    def heading(self, s: Array) -> Array:
        """Angle of the tangent [rad] at arc length `s`, 0 at the joint, shape (T,)."""
        late = np.maximum(s, self.knot)
        turned = 0.5 * (self.length - late) * (self.bend(late) + 1.0)
        return -turned - self.curvature * np.maximum(self.knot - s, 0.0)

    def point(self, s: Array) -> Array:
        """Position at arc length `s`, shape (T, 2)."""
        s = np.asarray(s, dtype=np.float64)
        middle = np.maximum(s, self.knot)
        return -(self._chord(s, middle) + self._chord(middle, np.full_like(s, self.length)))

    def _chord(self, start: Array, end: Array) -> Array:
        """Integral of the tangent from `start` to `end`, smooth in between, by Gauss-Legendre quadrature."""
        half = 0.5 * (end - start)
        s = 0.5 * (start + end)[:, None] + half[:, None] * _NODES
        angle = self.heading(s)
        return half[:, None] * np.stack([np.cos(angle) @ _WEIGHTS, np.sin(angle) @ _WEIGHTS], axis=1)


UNIT_LEAD = SmoothLead(curvature=2.0913321439700536, length=1.9966390507735365)
"""The smooth lead that starts at the centre (0, 1): its two numbers solve `point(0) = (0, 1)` to rounding; a test
solves for them again."""

LEADS: Mapping[str, SmoothLead | HalfCircle] = MappingProxyType({"smooth": UNIT_LEAD, "half_circle": HalfCircle()})
"""Leads by the names that `circle_test` knows."""


RADII = (0.001, 0.003, 0.005)
"""Radii of the test motion [m], thesis 2.2.5."""
SPEEDS = (0.010, 0.040, 0.100)
"""TCP speeds of the tests [m/s], thesis (2.16)."""
MIN_SAMPLES = 10
"""Fewest samples on a circle: with them the drive's interpolation stays within 5e-4 of the radius (see tests)."""
DWELL = 0.3
"""Rest before, between and after the circles [s]; chosen: several times the decay of the servo (about 0.1 s)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plane:
    """Plane of a circle: an orthonormal pair, in which circles run from `first` towards `second`."""

    first: Array
    second: Array

    def embed(self, flat: Array) -> Array:
        """World vectors (T, 3) of plane vectors (T, 2)."""
        return flat[:, [0]] * self.first + flat[:, [1]] * self.second


def plane_of(normal: Sequence[float] | Array) -> Plane:
    """Plane with a normal (3,) of any length; its first axis is the world's x, or y where x is along the normal."""
    normal = check_shape("normal", normal, (3,))
    largest = np.abs(normal).max()
    if largest < 1e-12:
        raise FFGymError(f"normal = {normal.tolist()} must not be zero; (0, 0, 1) is a plane parallel to the ground.")
    scaled = normal / largest  # so that no square overflows
    unit: Array = scaled / np.linalg.norm(scaled)
    guide = np.array([1.0, 0, 0]) if abs(unit[0]) < 0.9 else np.array([0, 1.0, 0])
    first = guide - unit * (guide @ unit)
    first /= np.linalg.norm(first)
    return Plane(first=first, second=np.cross(unit, first))


def circle_test(
    centre: Sequence[float] | Array,
    speed: float,
    *,
    radii: Sequence[float] = RADII,
    normal: Sequence[float] | Array = (0.0, 0.0, 1.0),
    start_angle: float = -np.pi / 2,
    dwell: float = DWELL,
    lead: str = "smooth",
    dt: float = 0.004,
    name: str = "circles",
) -> CartesianPath:
    """Circles around `centre` at constant TCP speed, each led in from the centre and led out back to it.

    Speed rises and falls on the leads only, with bounded jerk; on a circle it is `speed` exactly. Path, tangent and,
    with smooth leads, curvature are continuous.

    Args:
        centre: common centre and start point [m], shape (3,).
        speed: TCP speed on the circles [m/s], > 0.
        radii: radii [m], > 0, in the order in which they run.
        normal: normal of the plane, any length.
        start_angle: where each circle is joined [rad], from the plane's first axis.
        dwell: rest before, between and after the circles [s], > 0.
        lead: 'smooth', or 'half_circle' for the half circle of the thesis, where curvature and with it acceleration
            jump as it joins the circle.
        dt: sample time [s].
        name: name of the motion.

    Raises:
        FFGymError: if an argument is out of range.
    """
    centre = check_shape("centre", centre, (3,))
    speed = check_number("speed", speed, unit="m/s", low=0.0, open_low=True)
    dwell = check_number("dwell", dwell, unit="s", low=0.0, open_low=True)
    start_angle = check_number("start_angle", start_angle, unit="rad")
    sizes = check_shape("radii", radii, (None,))
    if len(sizes) == 0:
        raise FFGymError("radii is empty, must hold at least one radius in m.")
    plane = plane_of(normal)
    joined = LEADS[check_choice("lead", lead, list(LEADS))]
    # rest, then each circle with its leads and another rest
    segments = [standstill("rest 0", centre, dwell)]
    for i, size in enumerate(sizes):
        radius = check_number("radius", size, unit="m", low=0.0, open_low=True)
        dt = check_number("dt", dt, unit="s", low=0.0, open_low=True)
        turn = 2 * np.pi * radius
        if turn < MIN_SAMPLES * speed * dt:
            raise FFGymError(
                f"speed = {speed} m/s is too fast for radius = {radius} m: a turn takes {turn / speed / dt:.1f} "
                f"samples of {dt} s, must be {MIN_SAMPLES} or more, so at most {turn / MIN_SAMPLES / dt:.4g} m/s."
            )
        segments += _circle(centre, plane, radius, speed, start_angle, joined)
        segments.append(standstill(f"rest {i + 1}", centre, dwell))
    t, position, velocity, acceleration, phases = sample(segments, dt)
    return CartesianPath(name=name, t=t, position=position, velocity=velocity, acceleration=acceleration, phases=phases)


def circle_test_duration(speed: float, radii: Sequence[float] = RADII) -> float:
    """Compute the time [s] of `circle_test` at a speed [m/s] with circles of `radii` [m], before its path is made."""
    ways = sum((2 * np.pi + 4 * LEADS["smooth"].length) * radius for radius in radii)
    return float(ways / speed + DWELL * (len(radii) + 1))


def _circle(
    centre: Array, plane: Plane, radius: float, speed: float, start_angle: float, lead: SmoothLead | HalfCircle
) -> list[Segment]:
    """Lead-in, circle and lead-out."""
    ramp = 2 * lead.length * radius / speed  # the smooth speed ramp covers half of speed x time

    def on_lead(tau: Array, mirror: float) -> tuple[Array, Array, Array]:
        # speed ramp along the lead
        travelled, rate, change = smooth_ramp(tau, ramp, speed)
        s = np.clip(travelled / radius, 0.0, lead.length)
        angle, bend = lead.heading(s), lead.bend(s) / radius
        tangent = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        inward = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        # position, velocity and acceleration in the plane, with the centripetal part
        flat = (lead.point(s) - [0.0, 1.0]) * radius  # from the centre
        moved = (flat, rate[:, None] * tangent, change[:, None] * tangent + (rate**2 * bend)[:, None] * inward)
        # turn the unit picture (joint below the centre) to the start angle and put it into the world
        cos, sin = np.cos(start_angle + np.pi / 2), np.sin(start_angle + np.pi / 2)
        turn = np.array([[cos, -sin], [sin, cos]]) @ np.diag([mirror, 1.0])
        position, velocity, acceleration = (plane.embed(part @ turn.T) for part in moved)
        return centre + position, velocity, acceleration

    def lead_in(tau: Array) -> tuple[Array, Array, Array]:
        return on_lead(tau, 1.0)

    def lead_out(tau: Array) -> tuple[Array, Array, Array]:
        """The lead-in backwards in time, mirrored about the radius through the joint."""
        position, velocity, acceleration = on_lead(ramp - tau, -1.0)
        return position, -velocity, acceleration

    def circle(tau: Array) -> tuple[Array, Array, Array]:
        angle = start_angle + speed / radius * tau
        outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        tangent = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        flat = (radius * outward, speed * tangent, -(speed**2 / radius) * outward)
        position, velocity, acceleration = (plane.embed(part) for part in flat)
        return centre + position, velocity, acceleration

    label = f"{radius * 1e3:g} mm"
    return [
        Segment(label=f"lead-in {label}", kind="lead_in", duration=ramp, evaluate=lead_in),
        Segment(label=f"circle {label}", kind="circle", duration=2 * np.pi * radius / speed, evaluate=circle),
        Segment(label=f"lead-out {label}", kind="lead_out", duration=ramp, evaluate=lead_out),
    ]


def smooth_ramp(tau: Array, duration: float, speed: float) -> tuple[Array, Array, Array]:
    r"""Distance, speed and acceleration of a ramp from 0 to `speed`, :math:`3 x^2 - 2 x^3`: its jerk is bounded.

    `tau` are times since the start (T,) [s], within [0, duration]; the speed is in any unit per second.
    """
    x = np.clip(tau / duration, 0.0, 1.0)
    return (
        speed * duration * (x**3 - 0.5 * x**4),
        speed * (3 * x**2 - 2 * x**3),
        speed / duration * 6 * x * (1 - x),
    )

"""Model feed-forward along whole references: springs go sample by sample, all that follows from them in blocks.

It gives the bits of `ModelLaw.step`. Effects on springs remember, so that the torque that springs carry is found sample
by sample. Leads, states, friction and the torque of the existing controller follow from it, for many samples at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.agents.elastic import ElasticLaw
from ffgym.agents.flexible_joints import bristles_along, given_torque, in_parts, sum_limited
from ffgym.agents.model_memory import Carried, Past, change_parts
from ffgym.agents.model_springs import SpringEffects
from ffgym.agents.model_states import ModelStates, MotorEffects, state_between
from ffgym.control import DynamicLuGreExact, Window
from ffgym.core.types import Array, IntArray
from ffgym.paths import Reference

BLOCK = 64
"""Steps that are computed at once; chosen: from 32 on the time changes by less than a tenth, and arrays of a dozen
motions stay in the cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SideBySide:
    """References of B motions, the longest first; each holds its last sample beyond its end, (M, B, N)."""

    q: Array
    """Joint position, link side [rad]."""
    motor_dq: Array
    """Motor speed [rad/s]."""
    motor_ddq: Array
    """Motor acceleration [rad/s^2]."""
    dt: float
    """Time between samples [s]."""
    steps: IntArray
    """Steps of each motion, shape (B,)."""

    @classmethod
    def of(cls, references: Sequence[Reference], preview: int) -> "SideBySide":
        """Stack references, the longest first, with `preview` samples more than it has."""
        length = len(references[0].t) + preview

        def stack(series: list[Array]) -> Array:
            return np.stack([np.pad(x, ((0, length - len(x)), (0, 0)), mode="edge") for x in series], axis=1)

        return cls(
            q=stack([reference.q for reference in references]),
            motor_dq=stack([reference.motor_dq for reference in references]),
            motor_ddq=stack([reference.motor_ddq for reference in references]),
            dt=references[0].robot.servo.control_dt,
            steps=np.array([len(reference.t) - 1 for reference in references]),
        )

    def first_window(self, preview: int) -> Window:
        """Return the window with which the motions begin, (B, P + 1, N)."""
        q, motor_dq, motor_ddq = (part.swapaxes(0, 1) for part in self.at(0, preview + 1, len(self.steps)))
        return Window(q=q, motor_dq=motor_dq, motor_ddq=motor_ddq, dt=self.dt)

    def at(self, first: int, count: int, going: int) -> tuple[Array, Array, Array]:
        """Return position, motor speed and motor acceleration of the first `going` motions at `count` samples."""
        rows = slice(first, first + count)
        return self.q[rows, :going], self.motor_dq[rows, :going], self.motor_ddq[rows, :going]


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelAlong:
    """Equations of model feed-forward for blocks of samples, where no friction is behind the elasticity.

    Effects on motors must not remember. Members are those of the law.
    """

    elastic: ElasticLaw
    springs: SpringEffects
    states: ModelStates
    motors: MotorEffects
    friction: DynamicLuGreExact

    def torques(self, motions: SideBySide, past: Past) -> list[Array]:
        """Compute the torque along each motion, motor side [N m], (T, N) each.

        Args:
            motions: references.
            past: memory of the law when they begin, (B, N).
        """
        longest = int(motions.steps[0])
        torques = np.zeros((longest + 1, *past.time.shape))
        for done in range(0, longest, BLOCK):
            going, count = int((motions.steps > done).sum()), min(BLOCK, longest - done)
            rows = slice(done + 1, done + 1 + count)
            torques[rows, :going], past = self._advance(past.first(going), motions, done + 1, count)
        return [torques[: steps + 1, i].copy() for i, steps in enumerate(motions.steps.tolist())]

    def _advance(self, past: Past, motions: SideBySide, first: int, count: int) -> tuple[Array, Past]:
        """Compute the torque at `count` samples from `first` on, (K, B, N), and the memory at the sample after them."""
        dt, start, machine = motions.dt, past.start, self.springs.machine
        drive, going, reach = machine.physical.drive, len(past.time), len(past.carried) // 2
        motion, next_motion = (motions.at(first + k, count, going) for k in (0, 1))
        # torque that springs carry, and the leads that follow from it
        carried, springs = self._carry(past, motions.at(first + reach + 1, count, going), dt)
        bends = np.stack([carried.bend[k : k + count] - start.bend for k in range(2 * reach + 1)], axis=-2)
        next_lead = self.elastic.lead(bends, dt)
        lead = change_parts(_shift, past.lead, next_lead)
        # states at both ends of each step
        times = np.add.accumulate(np.concatenate([past.time[None], np.full((count, *past.time.shape), dt)]))
        held, next_held = (change_parts(lambda x, k=k: x[k : k + count], carried) for k in (reach - 1, reach))
        here = self.states.at(motion, held, lead, start, times[:-1])
        after = self.states.at(next_motion, next_held, next_lead, start, times[1:])
        # friction less torque of effects, in the middle of sub-steps
        law, between = self.friction, state_between(here, after, self.friction.shares)
        middles, speeds, bristle = bristles_along(law, past.bristle, here.motor_speed, after.motor_speed, dt)
        friction = (1 - machine.physical.arm_share) * law.friction.torque(middles, speeds)
        added, motors = self.motors.within(between.with_values(bristle=middles), friction, past.motors, dt)
        lost, next_lost = in_parts(friction - added)
        # lead as the servo sees it, and its integral
        seen, next_seen = self.states.seen(here, lead, start), self.states.seen(after, next_lead, start)
        load = drive.joint_torque(drive.motor_torque(start.load) - start.added)
        integral = sum_limited(past.integral, 0.5 * dt * (seen.angle + next_seen.angle), self.elastic.known, load)
        # torque that moves arm and motors, less that of the existing controller
        needed = here.command - drive.motor_torque(start.load) + _shift(past.lost, next_lost) + lost + start.added
        given = given_torque(self.elastic.known, *motion, seen, integral[:-1])
        later = Past(
            start=start,
            carried=tuple(change_parts(lambda x, k=k: x[k], carried) for k in range(count, count + 2 * reach)),
            time=times[-1],
            lead=change_parts(lambda x: x[-1], next_lead),
            integral=integral[-1],
            bristle=bristle,
            lost=next_lost[-1],
            springs=springs,
            motors=motors,
        )
        return needed - given, later

    def _carry(self, past: Past, motion: tuple[Array, Array, Array], dt: float) -> tuple[Carried, list[Array]]:
        """Compute the torque carried at the samples of `past` and at those of `motion`, (2 w + K, B, N).

        The memories of effects on springs at the last of them come second.
        """
        needed, joint_dq = self.elastic.links(*motion), self.springs.machine.physical.drive.joint_angle(motion[1])
        rows, springs = list(past.carried), past.springs
        for load, q, dq in zip(needed, motion[0], joint_dq, strict=True):
            row, springs = self.springs.next(load, q, dq, past.start.bend, rows[-1], springs, dt)
            rows.append(row)
        return change_parts(lambda *each: np.stack(each), *rows), springs


def _shift(before: Array, values: Array) -> Array:
    """Return values (K, ...) one step later, after the one `before` them."""
    return np.concatenate([before[None], values[:-1]])

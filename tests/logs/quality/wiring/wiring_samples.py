"""Logs of the diagnosis protocol, and 43 mistakes that can be made with their columns."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from ffgym.effects import EFFECTS, Effect
from ffgym.logs.quality.wiring.hypothesis import EFFORTS, MOTIONS
from ffgym.recordings import Recording, Rewire, Rewiring
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import PROTOCOLS, plan_session, record
from ffgym.simulation.protocols.sessions import usual_sensors
from scripts.exam.hidden import drawn

DT = 0.004
KNOWN = tuple(family for family in MOTIONS if family != "reference.acceleration")


@cache
def clean(robot: str, dt: float = DT) -> tuple[Recording, ...]:
    """Logs of the diagnosis protocol, as sensors see them."""
    return recorded(load_robot(robot), dt=dt)


def recorded(robot: RobotDescription, *effects: Effect, dt: float = DT) -> tuple[Recording, ...]:
    """Logs of a robot with effects."""
    arm = RigidArm(robot)
    machine = Machine(robot=robot, effects=effects)
    rig = SimulatedRig(arm=arm, machine=machine, sensors=usual_sensors(robot))
    session = plan_session(arm, [PROTOCOLS["diagnosis"]()])
    return tuple(record(session, rig, record_dt=dt, seed=1, n_threads=1))


def bare(recordings: tuple[Recording, ...]) -> tuple[Recording, ...]:
    """The same logs of a machine that tells positions and torques alone."""
    kept = ("timestamp", "motor.position", "motor.effort")
    return tuple(
        Recording({name: x for name, x in log.columns.items() if name.startswith(kept)}, log.header)
        for log in recordings
    )


@dataclass(frozen=True)
class Made:
    """A mistake: what it is, and what it makes of right columns."""

    kind: str
    families: tuple[str, ...]
    joints: tuple[int, ...]
    change: Rewiring

    def to(self, recordings: tuple[Recording, ...]) -> list[Recording]:
        """Logs with the mistake."""
        return [self.change.apply(recording) for recording in recordings]


def mistakes(robot: RobotDescription) -> dict[str, Made]:
    """43 mistakes by name, each with one joint or with all."""
    n, made = robot.n_joints, {}
    ratio = np.abs(robot.drive.gear_ratio)
    kt = np.array([0.31, 0.31, 0.27, 0.22, 0.22, 0.18])[:n]
    pair = (0, 1) if n == 2 else (1, 2)

    def add(name, kind, families, joints, change):
        none = Rewire.none(n)
        families = families if isinstance(families, tuple) else (families,)
        made[name] = Made(kind, families, joints, Rewiring(families={f: change(none) for f in families}))

    for word, joints in (("one", (n - 1,)), ("all", tuple(range(n)))):

        def times(factors, joints=joints):
            return lambda none: none.scale_parts(joints, np.broadcast_to(factors, n)[list(joints)].tolist())

        groups = {"torque": "motor.effort", "torques": EFFORTS, "position": "motor.position", "motion": KNOWN}
        for name, families in (groups | {"channels": (*KNOWN, *EFFORTS)}).items():
            add(f"sign of {name}, {word}", "sign", families, joints, times(-1.0))
        for name in ("position", "motion"):
            add(f"degrees for radians, {name}, {word}", "unit", groups[name], joints, times(180 / np.pi))
        for name in ("torque", "torques"):
            add(f"mN m for N m, {name}, {word}", "unit", groups[name], joints, times(1e3))
            for delay in (0.052, 0.1):
                late = lambda none, joints=joints, delay=delay: none.delay_parts(joints, -delay)  # noqa: E731
                add(f"{name} late by {delay} s, {word}", "delay", groups[name], joints, late)
        add(f"1/min for rad/s, {word}", "unit", "motor.velocity", joints, times(30 / np.pi))
        add(f"ampere for N m, {word}", "current", EFFORTS, joints, times(1 / kt))
        add(f"link side of motion, {word}", "side", KNOWN, joints, times(1 / ratio))
        add(f"link side of torques, {word}", "side", EFFORTS, joints, times(ratio))
    order = [*range(n)]
    order[pair[0]], order[pair[1]] = pair[1], pair[0]
    for name, families in (groups | {"channels": (*KNOWN, *EFFORTS)}).items():
        add(f"swap of {name}", "swap", families, pair, lambda none: none.permute(order))
    for name, factor in (("ms for s", 1e3), ("s for ms", 1e-3), ("twice as fast", 2.0), ("half as fast", 0.5)):
        made[f"clock {name}"] = Made("clock", (), (), Rewiring(clock=factor))
    return made


def hidden(robot: RobotDescription, seed: int) -> list[tuple[str, Effect]]:
    """One effect of each kind of the library, at the end of its plausible range, on a joint by chance."""
    rng = np.random.default_rng(seed)
    found = [drawn(kind, robot, rng) for name, kind in EFFECTS.items() if name != "link_clock"]
    return [(f"{one.effect.name} {one.joint}".strip(), one.effect) for one in found]


def noisy(recording: Recording, noise: float, rng: np.random.Generator, *, derived: bool) -> Recording:
    """The log with white noise of joint angles [rad], link side; its speeds from them, or left away."""
    angle = recording.joint_array("motor.position")
    angle = angle + noise * np.abs(recording.header.gear_ratio) * rng.standard_normal(angle.shape)
    speed = np.gradient(angle, recording.t, axis=0)
    columns = dict(recording.columns)
    for j, joint in enumerate(recording.header.joints):
        columns[f"motor.position.{joint}"] = angle[:, j]
        columns[f"motor.velocity.{joint}"] = speed[:, j]
    kept = ("timestamp", "motor", "reference", "tcp.") if derived else ("timestamp", "motor.position", "motor.effort")
    columns = {name: x for name, x in columns.items() if name.startswith(kept)}
    fields = {f: getattr(recording.header, f) for f in recording.header.__dataclass_fields__} | {"encoder_bits": None}
    return Recording(columns, type(recording.header)(**fields))

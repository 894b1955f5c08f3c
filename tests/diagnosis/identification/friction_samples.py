"""Recordings with known friction: the exact run once, what sensors see of it as often as needed."""

import numpy as np

from ffgym.recordings import Recording
from ffgym.robot import ModelOptions
from ffgym.simulation import Resolver, SimulatedRig, TorqueSensor
from ffgym.simulation.protocols import plan_session, record
from ffgym.simulation.protocols.one_by_one import SpeedLadder, Table61
from ffgym.simulation.sensors import measure

FINE_DT = 6.25e-5
"""Physics step of sines [s]: at the usual 0.25 ms the plant's own bristles lag by a step, which is 1 to 2 % of sigma_0
and sigma_1 at 10 rad/s, and no fault of the identification."""

SPEEDS = (0.02, 0.05, 0.09, 0.13, 0.18, 0.25, 0.4, 3.0, 9.0, 14.0)
"""Motor speeds of a short ladder [rad/s]."""


def ladder(arm, joints=(), speeds=SPEEDS) -> list[Recording]:
    """Exact recordings of constant speeds."""
    plan = plan_session(arm, [SpeedLadder(joints=joints, speeds=speeds, longest=4.0)])
    return list(record(plan, SimulatedRig(arm=arm, sensors=()), record_dt=1e-3))


def sines(arm, records, joints=(), record_dt=1e-3, physics_dt=FINE_DT, least=3.0) -> list[Recording]:
    """Exact recordings of records of table 6.1."""
    plan = plan_session(arm, [Table61(joints=joints, records=records, least=least)])
    options = ModelOptions(physics_dt=physics_dt, looks=False)
    return list(record(plan, SimulatedRig(arm=arm, sensors=(), options=options), record_dt=record_dt))


def measured(recordings, noise=0.05, seed=0) -> list[Recording]:
    """What resolvers of 16 bit and noisy torque sensors [N m] see of exact recordings."""
    n = len(recordings[0].header.joints)
    sensors = (Resolver(bits=16), TorqueSensor(noise=np.full(n, noise)))
    generators = np.random.default_rng(seed).spawn(len(recordings))
    return [measure(recording, sensors, rng) for recording, rng in zip(recordings, generators, strict=True)]

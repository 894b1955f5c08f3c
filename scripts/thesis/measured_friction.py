"""Friction of a workcell's joints as measurements show it: constant speeds and the fifteen records of Table 6.1."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from ffgym.diagnosis.identification import (
    FrictionIdentification,
    FrictionTorque,
    ModelError,
    Validation,
    friction_torques,
    identify_friction,
    validate,
)
from ffgym.published import ESTIMATION_RECORDS, FRICTION_RECORDS
from ffgym.robot.friction import LuGreParameters
from ffgym.simulation import Rig
from ffgym.simulation.protocols import Protocol, plan_session, record
from ffgym.simulation.protocols.one_by_one import SpeedLadder, Table61
from ffgym.simulation.run import Progress

LADDERS = ((0.02,), (0.04,), (0.07,), (0.1,), (0.15,), (0.22,), (0.4, 0.7, 1.5), (3.0, 6.0, 10.0, 14.0))
"""Motor speeds [rad/s] of ladders that run side by side; the interval of thesis 6.1.1, from twice its slowest speed."""
LONGEST = 4.0
"""Longest run at one speed [s]; chosen: bristles have slipped by then but at the slowest speed."""
LEAST, PERIODS = 2.0, 2
"""Shortest time [s] and fewest periods of a record of Table 6.1, which does not say its length; chosen to keep
the simulation short."""
RECORD_DT = 1e-3
"""Sample time of the recordings [s]."""
ALL_RECORDS = tuple(each.number for each in FRICTION_RECORDS)
"""Numbers of the records of Table 6.1."""
RESAMPLES = 200
"""Resamples behind the intervals; chosen: half of the usual, intervals are not judged here."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredFriction:
    """Friction of some joints of a machine as measured, and as identified from part of it."""

    joint: str
    """The joint that figures show."""
    records: dict[int, FrictionTorque]
    """Its records of Table 6.1 that were made, by number."""
    found: FrictionIdentification
    """Friction from the ladders and set D."""
    _errors: dict[str, dict[int, Validation]] = field(default_factory=dict, init=False, repr=False)

    @property
    def index(self) -> int:
        """Place of the joint."""
        return self.found.prior.joints.index(self.joint)

    def model(self, name: str) -> LuGreParameters:
        """Friction that was 'identified', or the 'original' one that the controller's model carries."""
        return {"identified": self.found.friction, "original": self.found.prior.friction}[name]

    @property
    def known(self) -> ModelError:
        """Errors of the model of the arm that were found, which are no friction."""
        return self.found.model_error

    def errors_of(self, model: str) -> dict[int, Validation]:
        """Validate a model on each record, by number; inertia error and offset count for all alike; found once."""
        if model not in self._errors:
            found = self._errors[model] = {}
            for number, torque in self.records.items():
                parts = validate(self.model(model), [torque], self.known)
                [found[number]] = [part for part in parts if part.joint == self.joint]
        return self._errors[model]


def measure_friction(
    rig: Rig,
    joints: Sequence[str],
    numbers: Sequence[int],
    *,
    seed: int,
    n_threads: int,
    progress: Progress,
) -> MeasuredFriction:
    """Record ladders and records of Table 6.1 of joints on a machine, and identify their friction.

    Figures show the first of the `joints`. Of the records, whose `numbers` are made, those of set D are used; `seed` is
    that of sensor noise, random starts and resamples.
    """
    protocols: list[Protocol] = [SpeedLadder(joints=joints, speeds=speeds, longest=LONGEST) for speeds in LADDERS]
    protocols.append(Table61(joints=joints, records=numbers, least=LEAST, periods=PERIODS))
    plan = plan_session(rig.arm, protocols)
    recordings = list(record(plan, rig, seed=seed, record_dt=RECORD_DT, n_threads=n_threads, progress=progress))
    torques = friction_torques(rig.arm, recordings)
    n_ladders = len(LADDERS) * len(joints)
    sines, of_sine = torques[n_ladders:], [*numbers] * len(joints)
    used = [torque for torque, number in zip(sines, of_sine, strict=True) if number in ESTIMATION_RECORDS]
    found = identify_friction([*torques[:n_ladders], *used], joints=joints, seed=seed, n_resamples=RESAMPLES)
    return MeasuredFriction(joint=joints[0], records=dict(zip(numbers, sines, strict=False)), found=found)

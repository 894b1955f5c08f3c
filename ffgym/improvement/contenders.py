"""Feed-forward laws that are compared: of the model before and after the rounds, and of identified friction."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ffgym.agents.elastic import elastic_law
from ffgym.agents.lugre import dynamic_lugre
from ffgym.agents.model import model_law
from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.diagnosis.identification import friction_torques, identify_friction
from ffgym.improvement.rounds import Plan, Round
from ffgym.recordings.io import read_folder
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Rig
from ffgym.simulation.run import Progress

BASELINE = "lugre_dynamic"
"""Law that the gain is told against: dynamic LuGre with nominal parameters."""
IDENTIFIED = "lugre_identified"
"""The same with friction that was identified from the first round's recordings."""
BENT = "elastic_identified"
"""Elastic feed-forward with that friction."""
FITTED = "fitted"
"""The nominal model with all numbers fitted to the first round's recordings, before any diagnosis."""
MODEL = "model"
"""Feed-forward from the last extended model; that of an earlier round has its number behind it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Contender:
    """A law, and what it is called here."""

    name: str
    title: str
    """Words for readers."""
    law: FeedForwardLaw


def contenders(rig: Rig, plan: Plan, rounds: Sequence[Round], identified: RobotDescription) -> list[Contender]:
    """All laws, in the order of tables.

    Args:
        rig: where they will run; its controller is what stays.
        plan: has the nominal model.
        rounds: have the extended ones.
        identified: the nominal robot with friction identified from the same recordings.
    """
    nominal = plan.nominal.physical
    bent, told = elastic_law(RigidArm(nominal), rig.arm), elastic_law(RigidArm(identified), rig.arm, BENT)
    found = [
        Contender(name="none", title="no compensation", law=NoCompensation()),
        Contender(name=BASELINE, title="dynamic LuGre, nominal", law=dynamic_lugre(nominal)),
        Contender(name=IDENTIFIED, title="dynamic LuGre, identified friction", law=dynamic_lugre(identified)),
        Contender(name="elastic", title="elastic, nominal", law=bent),
        Contender(name=BENT, title="elastic, identified friction", law=told),
    ]
    if plan.fit:
        law = model_law(rounds[0].before, rig.arm, FITTED)
        found.append(Contender(name=FITTED, title="all numbers fitted", law=law))
    grown = [each for each in rounds if each.diagnosis.causes] or rounds[-1:]
    for each in grown:
        name = MODEL if each is grown[-1] else f"{MODEL}_{each.number}"
        law = model_law(each.machine, rig.arm, name)
        found.append(Contender(name=name, title=f"extended model of round {each.number}", law=law))
    return found


def identified_robot(plan: Plan, first: Round, progress: Progress | None = None) -> RobotDescription:
    """The nominal robot with friction identified from the recordings of a round.

    Raises:
        FFGymError: if they cannot be read, or are not good for it.
    """
    nominal = plan.nominal.physical
    torques = friction_torques(RigidArm(nominal), read_folder(first.logs))
    found = identify_friction(torques, seed=plan.seed, progress=progress)
    return replace(nominal, friction=found.friction)

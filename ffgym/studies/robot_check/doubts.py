"""Everything that is asked of a description, with the entries that each question needs."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ffgym.robot import RobotDescription, RobotDraft
from ffgym.studies.robot_check import body_doubts, drive_doubts


@dataclass(frozen=True)
class Question:
    """A question of plausibility."""

    capability: str
    """What the description must allow, see `ffgym.robot.reading.draft`."""
    also: tuple[str, ...]
    """Entries that it needs beside."""
    ask: Callable[[RobotDescription], Iterator[str]]
    """Yields a sentence per doubt, which begins with the entry."""


QUESTIONS = (
    Question("link_torque", (), body_doubts.far_masses),
    Question("link_torque", (), body_doubts.odd_inertias),
    Question("link_torque", (), body_doubts.odd_gravity),
    Question("motor_torque", (), drive_doubts.odd_rotors),
    Question("kinematics", ("drive.gear_ratio", "kinematics.max_speed"), drive_doubts.fast_motors),
    Question("locked_resonances", (), drive_doubts.odd_resonances),
    Question("locked_resonances", ("drive.joint_damping",), drive_doubts.slow_damping),
    Question("torque_margin", (), drive_doubts.weak_motors),
    Question("lugre_dynamic", (), drive_doubts.odd_bristles),
    Question("simulation", (), drive_doubts.long_step),
)
"""All questions; one is skipped where the description does not say enough to ask it."""


def doubts_about(draft: RobotDraft) -> list[str]:
    """Sentences about numbers that are valid but hardly true, each beginning with the entry."""
    found: list[str] = []
    for question in QUESTIONS:
        if draft.can(question.capability, *question.also):
            found += question.ask(draft.description_for(question.capability, *question.also))
    return found

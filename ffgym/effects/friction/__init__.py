"""Friction of motor and gearbox, motor side."""

from ffgym.effects.friction.coulomb import CoulombLevel as CoulombLevel
from ffgym.effects.friction.load import LoadFriction as LoadFriction

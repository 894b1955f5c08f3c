"""Friction of motor and gearbox, motor side."""

from ffgym.effects.friction.asymmetry import Asymmetry as Asymmetry
from ffgym.effects.friction.coulomb import CoulombLevel as CoulombLevel
from ffgym.effects.friction.coulomb_drift import CoulombDrift as CoulombDrift
from ffgym.effects.friction.dwell import DwellStiction as DwellStiction
from ffgym.effects.friction.falling import FallingFriction as FallingFriction
from ffgym.effects.friction.load import LoadFriction as LoadFriction
from ffgym.effects.friction.nonlinear_viscous import NonlinearViscous as NonlinearViscous
from ffgym.effects.friction.position import PositionFriction as PositionFriction
from ffgym.effects.friction.presliding import PreslidingStiffness as PreslidingStiffness
from ffgym.effects.friction.stribeck import StribeckPeak as StribeckPeak
from ffgym.effects.friction.stribeck_exponent import StribeckExponent as StribeckExponent
from ffgym.effects.friction.temperature import TemperatureFriction as TemperatureFriction
from ffgym.effects.friction.viscous import ViscousLevel as ViscousLevel
from ffgym.effects.friction.viscous_drift import ViscousDrift as ViscousDrift

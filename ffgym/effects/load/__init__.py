"""What the arm carries: masses, springs, cables."""

from ffgym.effects.load.cable import CablePull as CablePull
from ffgym.effects.load.gravity_term import GravityTerm as GravityTerm
from ffgym.effects.load.payload import Payload as Payload
from ffgym.effects.load.rotor_inertia import RotorInertia as RotorInertia

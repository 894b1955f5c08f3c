from .cable import CablePull as CablePull
from .gravity_term import GravityTerm as GravityTerm
from .payload import Payload as Payload
from .rotor_inertia import RotorInertia as RotorInertia

"""All effects of the library by name, in the order of their codes."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.effects.effect import Effect
from ffgym.effects.friction import CoulombLevel, LoadFriction
from ffgym.effects.measurement import ResolverRipple
from ffgym.effects.transmission import KinematicError

_EFFECTS: tuple[type[Effect], ...] = (
    CoulombLevel,
    LoadFriction,
    KinematicError,
    ResolverRipple,
)

EFFECTS: Mapping[str, type[Effect]] = MappingProxyType({effect.name: effect for effect in _EFFECTS})
"""Every effect by name."""

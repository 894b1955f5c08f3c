"""Physics of the workcell in equations of its own: a diagnosis meets effects that its library only resembles."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.effects import Effect
from ffgym.workcell.equations.cold_oil import ColdOil as ColdOil
from ffgym.workcell.equations.gear_losses import GearLosses as GearLosses
from ffgym.workcell.equations.one_way_friction import OneWayFriction as OneWayFriction
from ffgym.workcell.equations.slip_elements import SlipElements as SlipElements
from ffgym.workcell.equations.slow_stribeck import SlowStribeck as SlowStribeck
from ffgym.workcell.equations.smooth_hysteresis import SmoothHysteresis as SmoothHysteresis
from ffgym.workcell.equations.two_harmonics import GearError as GearError
from ffgym.workcell.equations.two_harmonics import ResolverEccentricity as ResolverEccentricity
from ffgym.workcell.equations.two_harmonics import TorqueRipple as TorqueRipple

_EQUATIONS: tuple[type[Effect], ...] = (
    SlowStribeck,
    SlipElements,
    OneWayFriction,
    GearLosses,
    ColdOil,
    GearError,
    SmoothHysteresis,
    TorqueRipple,
    ResolverEccentricity,
)

EQUATIONS: Mapping[str, type[Effect]] = MappingProxyType({effect.name: effect for effect in _EQUATIONS})
"""Every equation by name."""

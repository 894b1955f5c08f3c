"""All effects of the library by name, in the order of their codes."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.effects import controller, drive, friction, load, measurement, transmission
from ffgym.effects.effect import Effect

_EFFECTS: tuple[type[Effect], ...] = (
    friction.CoulombLevel,
    friction.ViscousLevel,
    friction.StribeckPeak,
    friction.PreslidingStiffness,
    friction.Asymmetry,
    friction.LoadFriction,
    friction.TemperatureFriction,
    friction.NonlinearViscous,
    friction.PositionFriction,
    friction.DwellStiction,
    friction.StribeckExponent,
    friction.ViscousDrift,
    friction.CoulombDrift,
    friction.FallingFriction,
    transmission.JointStiffness,
    transmission.Hardening,
    transmission.TorsionalHysteresis,
    transmission.Backlash,
    transmission.KinematicError,
    transmission.WristCoupling,
    transmission.BaseFlexibility,
    transmission.FlexibleLoad,
    drive.Cogging,
    drive.TorqueRipple,
    drive.TorqueConstant,
    drive.TorqueOffset,
    drive.TorqueDelay,
    measurement.ResolverRipple,
    load.Payload,
    load.RotorInertia,
    load.GravityTerm,
    load.CablePull,
    measurement.ToolFrame,
    measurement.TrackerFrame,
    measurement.TrackerClock,
    measurement.JointZeros,
    measurement.TorqueClock,
    measurement.LinkClock,
    controller.ServoGains,
)

EFFECTS: Mapping[str, type[Effect]] = MappingProxyType({effect.name: effect for effect in _EFFECTS})
"""Every effect by name."""

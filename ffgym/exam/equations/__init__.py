"""Physics of exams: effects of the library in other equations, and effects that are outside it."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.exam.equations.clockwork import FloorVibration as FloorVibration
from ffgym.exam.equations.clockwork import RunningIn as RunningIn
from ffgym.exam.equations.clockwork import Shocks as Shocks
from ffgym.exam.equations.clockwork import SwitchedLoad as SwitchedLoad
from ffgym.exam.equations.clockwork import WanderingTorque as WanderingTorque
from ffgym.exam.equations.crosswise import DamagedTooth as DamagedTooth
from ffgym.exam.equations.crosswise import RubbingHose as RubbingHose
from ffgym.exam.equations.crosswise import SharedSeal as SharedSeal
from ffgym.exam.equations.crosswise import StirredOil as StirredOil
from ffgym.exam.equations.drive import BentTorqueConstant as BentTorqueConstant
from ffgym.exam.equations.drive import TwoLags as TwoLags
from ffgym.exam.equations.elasticity import DahlHysteresis as DahlHysteresis
from ffgym.exam.equations.elasticity import QuinticSpring as QuinticSpring
from ffgym.exam.equations.elasticity import RoundGap as RoundGap
from ffgym.exam.equations.elasticity import SteppedSpring as SteppedSpring
from ffgym.exam.equations.elasticity import StifferAlone as StifferAlone
from ffgym.exam.equations.losses import DirectionalEfficiency as DirectionalEfficiency
from ffgym.exam.equations.losses import DraggingShaft as DraggingShaft
from ffgym.exam.equations.losses import VogelOil as VogelOil
from ffgym.exam.equations.sliding import FallingCoulomb as FallingCoulomb
from ffgym.exam.equations.sliding import OneWaySeal as OneWaySeal
from ffgym.exam.equations.sliding import PowerViscous as PowerViscous
from ffgym.exam.equations.sliding import ShearThinning as ShearThinning
from ffgym.exam.equations.sticking import MaxwellSlip as MaxwellSlip
from ffgym.exam.equations.sticking import RateAndState as RateAndState
from ffgym.exam.equations.stribeck import LorentzStribeck as LorentzStribeck
from ffgym.exam.equations.stribeck import TanhStribeck as TanhStribeck
from ffgym.exam.equations.surroundings import CounterweightLinkage as CounterweightLinkage
from ffgym.exam.equations.surroundings import SmoothCable as SmoothCable
from ffgym.exam.equations.variant import Clue as Clue
from ffgym.exam.equations.variant import Outsider as Outsider
from ffgym.exam.equations.variant import Variant as Variant
from ffgym.exam.equations.waves import TwoWaveCogging as TwoWaveCogging
from ffgym.exam.equations.waves import TwoWaveFriction as TwoWaveFriction
from ffgym.exam.equations.waves import TwoWaveGearError as TwoWaveGearError
from ffgym.exam.equations.waves import TwoWaveResolver as TwoWaveResolver
from ffgym.exam.equations.waves import TwoWaveRipple as TwoWaveRipple

_VARIANTS: tuple[type[Variant], ...] = (
    FallingCoulomb,
    PowerViscous,
    TanhStribeck,
    LorentzStribeck,
    MaxwellSlip,
    OneWaySeal,
    DirectionalEfficiency,
    VogelOil,
    ShearThinning,
    TwoWaveFriction,
    RateAndState,
    StifferAlone,
    SteppedSpring,
    QuinticSpring,
    DahlHysteresis,
    RoundGap,
    TwoWaveGearError,
    DraggingShaft,
    TwoWaveCogging,
    TwoWaveRipple,
    BentTorqueConstant,
    TwoLags,
    TwoWaveResolver,
    CounterweightLinkage,
    SmoothCable,
)

_OUTSIDERS: tuple[type[Outsider], ...] = (
    FloorVibration,
    SwitchedLoad,
    Shocks,
    WanderingTorque,
    RunningIn,
    RubbingHose,
    StirredOil,
    SharedSeal,
    DamagedTooth,
)

VARIANTS: Mapping[str, type[Variant]] = MappingProxyType({kind.name: kind for kind in _VARIANTS})
"""Effects of the library in other equations, by name."""

OUTSIDERS: Mapping[str, type[Outsider]] = MappingProxyType({kind.name: kind for kind in _OUTSIDERS})
"""Effects that the library cannot express, by name."""

"""Physics of exams: effects of the library in other equations, and effects that are outside it."""

from collections.abc import Mapping
from types import MappingProxyType

from scripts.exam.equations.clockwork import FloorVibration as FloorVibration
from scripts.exam.equations.clockwork import RunningIn as RunningIn
from scripts.exam.equations.clockwork import Shocks as Shocks
from scripts.exam.equations.clockwork import SwitchedLoad as SwitchedLoad
from scripts.exam.equations.clockwork import WanderingTorque as WanderingTorque
from scripts.exam.equations.crosswise import DamagedTooth as DamagedTooth
from scripts.exam.equations.crosswise import RubbingHose as RubbingHose
from scripts.exam.equations.crosswise import SharedSeal as SharedSeal
from scripts.exam.equations.crosswise import StirredOil as StirredOil
from scripts.exam.equations.drive import BentTorqueConstant as BentTorqueConstant
from scripts.exam.equations.drive import TwoLags as TwoLags
from scripts.exam.equations.elasticity import DahlHysteresis as DahlHysteresis
from scripts.exam.equations.elasticity import QuinticSpring as QuinticSpring
from scripts.exam.equations.elasticity import RoundGap as RoundGap
from scripts.exam.equations.elasticity import SteppedSpring as SteppedSpring
from scripts.exam.equations.elasticity import StifferAlone as StifferAlone
from scripts.exam.equations.losses import DirectionalEfficiency as DirectionalEfficiency
from scripts.exam.equations.losses import DraggingShaft as DraggingShaft
from scripts.exam.equations.losses import VogelOil as VogelOil
from scripts.exam.equations.sliding import FallingCoulomb as FallingCoulomb
from scripts.exam.equations.sliding import OneWaySeal as OneWaySeal
from scripts.exam.equations.sliding import PowerViscous as PowerViscous
from scripts.exam.equations.sliding import ShearThinning as ShearThinning
from scripts.exam.equations.sticking import MaxwellSlip as MaxwellSlip
from scripts.exam.equations.sticking import RateAndState as RateAndState
from scripts.exam.equations.stribeck import LorentzStribeck as LorentzStribeck
from scripts.exam.equations.stribeck import TanhStribeck as TanhStribeck
from scripts.exam.equations.surroundings import CounterweightLinkage as CounterweightLinkage
from scripts.exam.equations.surroundings import SmoothCable as SmoothCable
from scripts.exam.equations.variant import Clue as Clue
from scripts.exam.equations.variant import Outsider as Outsider
from scripts.exam.equations.variant import Variant as Variant
from scripts.exam.equations.waves import TwoWaveCogging as TwoWaveCogging
from scripts.exam.equations.waves import TwoWaveFriction as TwoWaveFriction
from scripts.exam.equations.waves import TwoWaveGearError as TwoWaveGearError
from scripts.exam.equations.waves import TwoWaveResolver as TwoWaveResolver
from scripts.exam.equations.waves import TwoWaveRipple as TwoWaveRipple

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

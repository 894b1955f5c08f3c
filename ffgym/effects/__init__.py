"""Physical effects that a robot may have and its nominal model may lack."""

from ffgym.effects.along import torques_along as torques_along
from ffgym.effects.catalogue import EFFECTS as EFFECTS
from ffgym.effects.effect import ClockEffect as ClockEffect
from ffgym.effects.effect import Effect as Effect
from ffgym.effects.effect import ModelEffect as ModelEffect
from ffgym.effects.effect import NativeEffect as NativeEffect
from ffgym.effects.effect import ResolverEffect as ResolverEffect
from ffgym.effects.effect import TorqueEffect as TorqueEffect
from ffgym.effects.effect import TrackerEffect as TrackerEffect
from ffgym.effects.parameter import Parameter as Parameter
from ffgym.effects.parameter import parameter as parameter
from ffgym.effects.reading import Origin as Origin
from ffgym.effects.reading import effects_toml as effects_toml
from ffgym.effects.reading import read_effects as read_effects
from ffgym.effects.reading import read_origins as read_origins
from ffgym.effects.state import ResolverError as ResolverError
from ffgym.effects.state import State as State
from ffgym.effects.state import Torques as Torques

"""Rigid-body identification: inertial parameters that exist, rotors, friction and offsets, from recorded torque."""

from ffgym.identification.rigid_body.base import BaseParameters as BaseParameters
from ffgym.identification.rigid_body.base import base_parameters as base_parameters
from ffgym.identification.rigid_body.excitation import best_excitation as best_excitation
from ffgym.identification.rigid_body.excitation import excitation_condition as excitation_condition
from ffgym.identification.rigid_body.fit import RigidBodyFit as RigidBodyFit
from ffgym.identification.rigid_body.identify import RigidBodyOptions as RigidBodyOptions
from ffgym.identification.rigid_body.identify import identify_rigid_body as identify_rigid_body
from ffgym.identification.rigid_body.observation import Filtering as Filtering
from ffgym.identification.rigid_body.terms import TERMS as TERMS
from ffgym.identification.rigid_body.torque_errors import TorqueErrors as TorqueErrors
from ffgym.identification.rigid_body.trade_off import TradeOff as TradeOff
from ffgym.identification.rigid_body.unknown import starting_robot as starting_robot

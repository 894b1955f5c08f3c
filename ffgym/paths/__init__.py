"""Motions: circles with lead-in and lead-out, excitations of the joints; moves, curves and time laws for any other."""

from ffgym.paths.circles import DWELL as DWELL
from ffgym.paths.circles import RADII as RADII
from ffgym.paths.circles import SPEEDS as SPEEDS
from ffgym.paths.circles import circle_test as circle_test
from ffgym.paths.joint_space import constant_velocity as constant_velocity
from ffgym.paths.joint_space import joint_sine as joint_sine
from ffgym.paths.motion import CartesianPath as CartesianPath
from ffgym.paths.motion import JointPath as JointPath
from ffgym.paths.multisine import multisine as multisine
from ffgym.paths.multisine import schroeder_phases as schroeder_phases
from ffgym.paths.random_motion import random_multisine as random_multisine
from ffgym.paths.speed_steps import speed_ladder as speed_ladder
from ffgym.paths.speed_steps import triangle as triangle

"""What lies between motor and link."""

from ffgym.effects.transmission.kinematic_error import KinematicError as KinematicError

"""Friction models, motor side."""

from ffgym.friction.lugre import LuGreParameters as LuGreParameters

"""Figures of merit of a recording."""

from ffgym.metrics.circle import Circle as Circle
from ffgym.metrics.circle import fit_circle as fit_circle
from ffgym.metrics.contour import Contour as Contour
from ffgym.metrics.contour import ContourError as ContourError
from ffgym.metrics.contour import contour_errors as contour_errors
from ffgym.metrics.contour import start_offset as start_offset
from ffgym.metrics.friction_miss import friction_miss as friction_miss
from ffgym.metrics.friction_miss import relative_rms as relative_rms
from ffgym.metrics.motor_error import motor_error as motor_error
from ffgym.metrics.motor_error import motor_error_rms as motor_error_rms
from ffgym.metrics.path_error import PathError as PathError
from ffgym.metrics.path_error import circle_deviation as circle_deviation
from ffgym.metrics.path_error import deviation_along as deviation_along
from ffgym.metrics.path_error import path_errors as path_errors
from ffgym.metrics.path_error import standstill_offset as standstill_offset

"""Numbers that others published, as data."""

from ffgym.published.thesis import METHODS as METHODS
from ffgym.published.thesis import published_mm as published_mm

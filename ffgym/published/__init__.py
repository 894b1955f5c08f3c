"""Numbers that others published, as data."""

from ffgym.published.kr300 import KR300_FRICTION as KR300_FRICTION
from ffgym.published.kr300 import AsymmetricFriction as AsymmetricFriction
from ffgym.published.thesis import METHODS as METHODS
from ffgym.published.thesis import published_mm as published_mm

"""Numbers that others published, as data."""

from ffgym.published.emps import EMPS_ASYMMETRIC as EMPS_ASYMMETRIC
from ffgym.published.emps import EMPS_SYMMETRIC as EMPS_SYMMETRIC
from ffgym.published.emps import EmpsModel as EmpsModel
from ffgym.published.friction_records import ESTIMATION_RECORDS as ESTIMATION_RECORDS
from ffgym.published.friction_records import FRICTION_RECORDS as FRICTION_RECORDS
from ffgym.published.friction_records import FrictionRecord as FrictionRecord
from ffgym.published.kr300 import KR300_FRICTION as KR300_FRICTION
from ffgym.published.kr300 import AsymmetricFriction as AsymmetricFriction
from ffgym.published.thesis import METHODS as METHODS
from ffgym.published.thesis import published_mm as published_mm

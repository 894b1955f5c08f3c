"""The quality gate: what a recording is good for, each figure beside its limit and the reason of that limit."""

from ffgym.quality.check import Check as Check
from ffgym.quality.finding import Finding as Finding
from ffgym.quality.finding import QualityReport as QualityReport
from ffgym.quality.gate import CHECKS as CHECKS
from ffgym.quality.gate import STAGES as STAGES
from ffgym.quality.gate import check_quality as check_quality
from ffgym.quality.needs import NEEDS as NEEDS
from ffgym.quality.needs import Need as Need

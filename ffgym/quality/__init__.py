"""The quality gate: what a recording is good for, each figure beside its limit and the reason of that limit."""

from ffgym.quality.check import Check as Check
from ffgym.quality.conditioning import conditioned as conditioned
from ffgym.quality.conditioning import notes_of as notes_of
from ffgym.quality.finding import Finding as Finding
from ffgym.quality.finding import QualityReport as QualityReport
from ffgym.quality.gate import CHECKS as CHECKS
from ffgym.quality.gate import STAGES as STAGES
from ffgym.quality.gate import check_quality as check_quality
from ffgym.quality.judged import Judged as Judged
from ffgym.quality.judged import accepted as accepted
from ffgym.quality.judged import conditioned_alike as conditioned_alike
from ffgym.quality.judged import judged as judged
from ffgym.quality.needs import NEEDS as NEEDS
from ffgym.quality.needs import Need as Need

"""Every listed defect of a log is refused when the recording is made, or named by the quality gate."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.logs.quality import Finding, check_quality
from ffgym.recordings import Recording
from tests.logs.quality.defects import DEFECTS, Damaged, Defect
from tests.logs.quality.quality_logs import clean_log, described

FAST = (("irb4600_60_205", "multisine"), ("two_link", "multisine"))
SLOW = (
    *FAST,
    ("irb4600_60_205", "ladder"),
    ("kuka_kr300_r2500", "square"),
    ("kuka_kr300_r2500", "triangle"),
    ("two_link", "ladder"),
)


def applicable(defect: Defect, recording: Recording) -> bool:
    return len(recording.header.joints) >= defect.least_joints and all(recording.has(name) for name in defect.needs)


def names(finding: Finding, defect: Defect, damaged: Damaged) -> bool:
    """Whether a finding names the defect, and its joint and column where it has them."""
    right_joint = not damaged.joint or finding.joint in ("", damaged.joint)
    at_fault = set(damaged.columns_at_fault)
    right_column = not at_fault or not finding.columns or bool(at_fault & set(finding.columns))
    return finding.check in defect.checks and right_joint and (right_column or finding.columns == ("motor.effort",))


def refused_or_named(defect: Defect, robot: str, motion: str, seed: int) -> None:
    clean = clean_log(robot, motion)
    if not applicable(defect, clean):
        pytest.skip(f"{robot} has nothing to do this to")
    damaged = defect.inject(clean, np.random.default_rng(seed))
    if not defect.checks:
        with pytest.raises(FFGymError):
            Recording(damaged.columns, damaged.header)
        return
    report = check_quality(Recording(damaged.columns, damaged.header), described(robot, motion))
    found = [f"{finding.check} {finding.verdict}: {finding.message}" for finding in report.problems]
    assert any(names(finding, defect, damaged) for finding in report.problems), (damaged.joint, found)
    assert report.problems[0].check in defect.checks, found  # what is read first is the reason, not a consequence
    assert report.verdict != "good"


def test_there_are_more_defects_than_the_acceptance_asks_for():
    assert len({defect.name for defect in DEFECTS}) >= 40


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
@pytest.mark.parametrize(("robot", "motion"), FAST)
def test_a_defect_is_refused_or_named_first(defect, robot, motion):
    refused_or_named(defect, robot, motion, seed=11)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
@pytest.mark.parametrize(("robot", "motion"), SLOW)
def test_a_defect_is_named_in_any_log_joint_and_size(defect, robot, motion, seed):
    refused_or_named(defect, robot, motion, seed)

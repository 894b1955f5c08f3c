"""The text of the quality gate: each problem is told once."""

from ffgym.logs.quality import Finding, QualityReport
from ffgym.report.quality import format_quality


def test_a_problem_that_several_joints_share_is_told_once():
    shared = [Finding(check="need_friction", verdict="flagged", message="j2, j3 rest.", joint=j) for j in ("j2", "j3")]
    other = Finding(check="spike", verdict="flagged", message="j1 jumps.", joint="j1")
    report = QualityReport(robot="cell", segment="", n_rows=10, duration=1.0, findings=(*shared, other))
    assert format_quality(report).splitlines()[1:] == [
        "flagged: [need_friction] j2, j3 rest.",
        "flagged: [spike] j1 jumps.",
    ]

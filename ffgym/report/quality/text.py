"""What the quality gate found in a recording, as text for a terminal."""

from ffgym.logs.quality import Finding, QualityReport
from ffgym.report.circles.tables import filled

_WORDS = {
    "good": "good: nothing to object to",
    "usable": "usable, with what is flagged in mind",
    "insufficient": "insufficient: do not conclude from it what hangs on what is refused",
}


def headline(report: QualityReport) -> str:
    """The verdict in one sentence."""
    name = f"{report.robot}, {report.segment}" if report.segment else report.robot
    return f"{name}: {report.n_rows} rows, {report.duration:.6g} s. {_WORDS[report.verdict].capitalize()}."


def format_quality(report: QualityReport, *, figures: bool = False) -> str:
    """The verdict and what could not be judged in a line, what conditioning did, every problem, of several joints once.

    Args:
        report: what was found.
        figures: also list every figure beside its limit, and the checks that were not judged.
    """
    unknown = dict.fromkeys(finding.check for finding in report.findings if finding.verdict == "not judged")
    lines = [headline(report) + (f" {len(unknown)} checks not judged." if unknown else "")]
    lines += [filled(f"conditioned: {note}") for note in report.conditioning]
    problems = [f"{finding.verdict}: [{finding.check}] {finding.message}" for finding in report.problems]
    lines += [filled(problem) for problem in dict.fromkeys(problems)]
    if figures:
        lines += [_figure(finding) for finding in report.findings if finding.value is not None]
        lines += [filled(f"not judged: {', '.join(unknown)}")] if unknown else []
    return "\n".join(lines)


def _figure(finding: Finding) -> str:
    limit = "" if finding.limit is None else f"{finding.limit:.4g}"
    return f"  {finding.check:20} {finding.place:26} {finding.value:12.4g} {limit:>10} {finding.unit}"

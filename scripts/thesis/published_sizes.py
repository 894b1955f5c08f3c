"""Claims about tables of path errors: simulated, published, and both beside one another."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from ffgym.published import published_mm
from ffgym.report import circle_tables
from ffgym.report.circles.comparison import FACTOR, reduction
from ffgym.studies import CircleStudy
from scripts.thesis.claims import EVERY, MOST, Check, Claim
from scripts.thesis.comparisons import label, mean_path_reduction
from scripts.thesis.laboratory import Laboratory

Circles = Callable[[Laboratory], CircleStudy]


def as_published(study: CircleStudy) -> CircleStudy:
    """The study with the published RMS path errors of the real robot; circles without one are left out."""
    found = [
        (cell, published_mm(cell.agent, "rms", cell.speed_mm_s / 1e3, cell.radius_mm / 1e3, cell.position))
        for cell in study.cells
    ]
    return replace(study, cells=[replace(cell, rms_mm=rms) for cell, rms in found if rms is not None])


def table_claim(
    name: str,
    statement: str,
    criterion: str,
    circles: Circles,
    checks: Callable[[CircleStudy], Sequence[Check]],
    share: float = EVERY,
) -> Claim:
    """Claim about the RMS path errors of a table, simulated, and the same comparisons of the published numbers."""
    return Claim(
        name=name,
        statement=statement,
        criterion=f"{criterion}, simulated.",
        checks=lambda laboratory: checks(circles(laboratory)),
        share=share,
        published=lambda laboratory: checks(as_published(circles(laboratory))),
    )


def sizes_as_published(name: str, circles: Circles, laws: Sequence[str]) -> Claim:
    """Claim that the simulated robot strays as far as the real one with every law."""
    return Claim(
        name=name,
        statement="The tool of the simulated robot and that of the real one move almost alike, with and without "
        "compensation (4.4, 5.4).",
        criterion=f"Simulated and published RMS path error of a circle within a factor of {FACTOR:g}, with every law; "
        "the robot was fitted to those without compensation.",
        checks=lambda laboratory: as_large_as_published(circles(laboratory), laws),
        share=MOST,
    )


def as_large_as_published(study: CircleStudy, laws: Sequence[str]) -> list[Check]:
    """Whether simulated and published RMS path error of a circle are within a factor of FACTOR of one another."""
    ratios = {
        (law, table.speed_mm_s, radius, position): ratio
        for table in circle_tables(study)
        for law in laws
        for (radius, position), ratio in table.ratios(law).items()
    }
    return [
        Check(
            where=f"{label(law)}, {position}, r = {radius:g} mm, the larger over the smaller",
            value=max(ratio, 1 / ratio),
            limit=FACTOR,
        )
        for (law, _, radius, position), ratio in ratios.items()
    ]


def more_gained_than_published(study: CircleStudy, laws: Sequence[str]) -> list[Check]:
    """Whether a larger share of the mean RMS path error is gone in simulation than was on the real robot."""
    [table] = circle_tables(study)
    gained = {law: reduction(table.mean_published_rms(law), table.mean_published_rms("none")) for law in laws}
    return [
        Check(
            where=f"{label(law)}, share of the mean RMS path error that is gone, published against simulated",
            value=share,
            limit=mean_path_reduction(study, law),
        )
        for law, share in gained.items()
        if share is not None
    ]

"""Verdict on a ranking of structures, as a word and as a sentence."""

from collections.abc import Sequence
from typing import Literal

from ffgym.diagnosis.tables.parts import find_structure
from ffgym.diagnosis.tables.ranking import RankedStructure
from ffgym.diagnosis.tables.structures import extends

TableVerdict = Literal["named", "partly", "ambiguous", "unknown"]
"""`named`: one structure leaves less than all others, but for those that contain it; `partly`: it does, but gets the
sign that is asked about wrong in half of the cells or more; `ambiguous`: several tie; `unknown`: none fits."""


def judge_structures(ranked: Sequence[RankedStructure]) -> tuple[TableVerdict, str]:
    """Judge a ranking: verdict, and the structure with fewest free numbers among those that tie, or the best."""
    tied = [one for one in ranked if one.is_tied]
    least = min(tied, key=lambda one: (one.fit.free_parameters, one.score))
    if not any(one.fits for one in tied):
        return "unknown", least.fit.name
    others = [one for one in tied if one is not least and not extends(one.fit.name, least.fit.name)]
    if others:
        return "ambiguous", least.fit.name
    return ("named" if 2 * least.sign_right > least.sign_cells or not least.sign_cells else "partly"), least.fit.name


def write_sentence(verdict: TableVerdict, best: str, ranked: Sequence[RankedStructure]) -> str:
    """Write the verdict in one sentence."""
    first = next(one for one in ranked if one.fit.name == best)
    reached = (
        f"{first.fitted_within_1_5} of {first.fitted_rms} fitted and {first.held_out_within_1_5} of "
        f"{first.held_out_rms} held-out RMS errors are within a factor 1.5"
    )
    title = find_structure(best).title
    if verdict == "unknown":
        ties = sum(one.is_tied for one in ranked)
        best_of = (
            f"of {ties} that tie for the best, {title} has fewest free numbers" if ties > 1 else f"the best is {title}"
        )
        return f"No structure explains the table; {best_of}: {reached}."
    if verdict == "named":
        return f"Consistent with {title}, beside numbers of the description: {reached}."
    if verdict == "partly":
        wrong = first.sign_cells - first.sign_right
        right = [one for one in ranked if one.sign_right == one.sign_cells]
        told = f" The best of those with the sign right is {right[0].fit.title}." if right else ""
        return (
            f"Sizes are consistent with {title}, beside numbers of the description: {reached}; but in {wrong} of "
            f"{first.sign_cells} cells it says that the law helps where it harms, or harms where it helps.{told}"
        )
    rivals = [one.fit.title for one in ranked if one.is_tied and one is not first]
    return f"Consistent with {title}: {reached}; as well with {'; '.join(rivals)}."

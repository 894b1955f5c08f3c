"""Thesis 6.1, LuGre friction of joint 1 identified anew: Figures 6.1 to 6.7 and Table 6.1, on a workcell.

The thesis measures a real robot; here a workcell stands for it, whose friction is no LuGre model alone, and whose
controller carries an older set of parameters: the original ones of Figures 6.6 and 6.7.
"""

from ffgym.published import ESTIMATION_RECORDS, FRICTION_RECORDS
from scripts.thesis.claims import CLEAR, MOST, ROUGH, ZERO, Claim
from scripts.thesis.identified_checks import good_fit, has_a_loop, matches, neither, original_is_worse
from scripts.thesis.identified_figures import (
    both,
    new,
    none,
    old,
    over_both,
    over_speed,
    parameters,
    records,
    static,
)
from scripts.thesis.items import Item

VALIDATING = tuple(each.number for each in FRICTION_RECORDS if each.number not in ESTIMATION_RECORDS)
"""Set V of thesis 6.1.2."""
EXAMPLE, FITTED, VALIDATED, SHOWN = 3, 4, 1, (3, 5, 6, 8, 11, 13)
"""Records of Figures 6.2, 6.3, 6.4 and 6.5. Captions and text of Figure 6.2 name 2 Hz and 1 Hz; taken is 1 Hz."""
ORIGINAL, FASTEST = (1, 10, 4), 15
"""Records of Figures 6.6 and 6.7."""

ITEMS = (
    Item(
        name="figure-6.1",
        chapter="chapter-6",
        title="static friction of joint 1, identified",
        figures=static,
        numbers=parameters,
        claims=(
            Claim(
                name="6.1-match",
                statement="The identified static curve matches the data points well.",
                criterion=f"RMS distance at most {ZERO:.0%} of the RMS friction.",
                checks=matches,
            ),
        ),
    ),
    Item(
        name="table-6.1",
        chapter="chapter-6",
        title="the fifteen records, and what the LuGre model leaves of them",
        numbers=records,
        claims=(
            Claim(
                name="T6.1-better",
                statement="On data that were not used the identified model is the better approximation (6.1.3).",
                criterion=f"RMS error at least {CLEAR:.0%} below that of the original parameters, records of set V.",
                checks=lambda laboratory: original_is_worse(laboratory, VALIDATING),
                share=MOST,
            ),
        ),
    ),
    Item(
        name="figure-6.2",
        chapter="chapter-6",
        title="estimated friction of joint 1 over time and speed",
        figures=over_both("figure-6.2", "Estimated friction", EXAMPLE, none),
        claims=(
            Claim(
                name="6.2-dynamic",
                statement="Over speed the estimated friction shows its dynamics.",
                criterion=f"Rising and falling speed are further apart than {ZERO:.0%} of the RMS friction.",
                checks=lambda laboratory: has_a_loop(laboratory, EXAMPLE),
            ),
        ),
    ),
    Item(
        name="figure-6.3",
        chapter="chapter-6",
        title="identified LuGre model on a record it was identified from",
        figures=over_both("figure-6.3", "Friction and identified model", FITTED, new),
        claims=(
            Claim(
                name="6.3-fit",
                statement="The identified model is a good fit to the estimation data.",
                criterion=f"RMS error below {ROUGH:.0%} of the RMS friction.",
                checks=lambda laboratory: good_fit(laboratory, [FITTED]),
            ),
        ),
    ),
    Item(
        name="figure-6.4",
        chapter="chapter-6",
        title="identified LuGre model on a record that was not used",
        figures=over_both("figure-6.4", "Friction and identified model", VALIDATED, new),
        claims=(
            Claim(
                name="6.4-fit",
                statement="The identified model is a good fit to validation data.",
                criterion=f"RMS error below {ROUGH:.0%} of the RMS friction.",
                checks=lambda laboratory: good_fit(laboratory, [VALIDATED]),
            ),
        ),
    ),
    Item(
        name="figure-6.5",
        chapter="chapter-6",
        title="identified LuGre model on six records that were not used",
        figures=over_speed("figure-6.5", "Friction and identified model", SHOWN, new),
        claims=(
            Claim(
                name="6.5-fit",
                statement="The identified model is a good fit to all six.",
                criterion=f"RMS error below {ROUGH:.0%} of the RMS friction.",
                checks=lambda laboratory: good_fit(laboratory, SHOWN),
            ),
        ),
    ),
    Item(
        name="figure-6.6",
        chapter="chapter-6",
        title="original LuGre model on three records",
        figures=over_speed("figure-6.6", "Friction and original model", ORIGINAL, old),
        claims=(
            Claim(
                name="6.6-original",
                statement="The original model is a bad fit, where the identified one is better.",
                criterion=f"RMS error of the identified model at least {CLEAR:.0%} lower.",
                checks=lambda laboratory: original_is_worse(laboratory, ORIGINAL),
            ),
        ),
    ),
    Item(
        name="figure-6.7",
        chapter="chapter-6",
        title="original and identified model on the fastest record",
        figures=over_speed("figure-6.7", "Friction and both models", [FASTEST], both),
        claims=(
            Claim(
                name="6.7-neither",
                statement="At 10 sin(2π 5 t) neither model captures the hysteresis.",
                criterion=f"RMS error above {ROUGH:.0%} of the RMS friction.",
                checks=lambda laboratory: neither(laboratory, FASTEST),
            ),
        ),
    ),
)

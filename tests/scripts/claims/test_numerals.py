"""Numbers in a text, and those that only name something."""

import pytest

from scripts.claims.numerals import find_names, find_numerals


def claimed(text):
    """Numerals of a text that no rule takes for a name."""
    names = find_names(text)
    return [
        numeral.text
        for numeral in find_numerals(text)
        if not any(start <= numeral.start < end for start, end, _ in names)
    ]


def test_a_number_has_its_point_its_thousands_and_its_exponent():
    assert claimed("1,098 um, 23.6 %, 2e-3 rad; 40 mm.") == ["1,098", "23.6", "2e-3", "40"]


@pytest.mark.parametrize(
    "text",
    [
        "`--seeds 5` and p1, UR10e, drives-3",
        "on 27 November 2026, in 2018, 2026-11-27",
        "Python 3.11, MuJoCo 4.0.0, ffgym/CirclePath-v1, ROS 2",
        "Tables 4.1, 4.2 and 5.1, Figure 5.11, (3.17), thesis 4.1, 6.1.3",
        "ISO 9283, UTF-8, IRB 4600-60/2.05, KR 300 R2500",
        "[text](page_2.md#part-3), https://doi.org/10.1016/j.ifacol.2018.11.578",
        "N m^2, $`x^2 + 3`$, arXiv:1707.06347, IFAC-PapersOnLine 51-22, 2018, 412-417",
        "seed 41, seeds 45 and 46",
        "at 10, 40 and 100 mm/s, r = 1 mm, the 5 mm circles, circles of 2.5 mm, within a factor of 1.5",
        "joint 3, axes 1 to 3, a 95 % interval",
        "3. third step",
    ],
)
def test_what_names_something_claims_nothing(text):
    assert claimed(text) == []


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("12.7 (7.5) of 12 rows", ["12.7", "7.5", "12"]),
        ("a 16-bit resolver at 4 ms", ["16", "4"]),
        ("p1 at 10 mm/s leaves 1.14 um", ["1.14"]),
        ("| j2 | 0.35 |", ["0.35"]),
    ],
)
def test_a_size_is_a_claim(text, numbers):
    assert claimed(text) == numbers

"""The published path errors are those that the thesis prints."""

import pytest

from ffgym.paths import RADII
from ffgym.published import ESTIMATION_RECORDS, FRICTION_RECORDS, METHODS, published_mm

# method, statistic, TCP speed [m/s]: rows are radii 1, 3, 5 mm, columns positions 1 to 4; thesis, tables 4.1 and 4.2
TABLES = {
    ("none", "max", 0.010): "0.31 0.24 0.23 0.31 / 0.18 0.26 0.3 0.22 / 0.23 0.26 0.27 0.27",
    ("none", "rms", 0.010): "0.14 0.109 0.122 0.138 / 0.074 0.095 0.109 0.098 / 0.078 0.091 0.106 0.105",
    ("lugre_static", "max", 0.010): "0.15 0.19 0.15 0.13 / 0.11 0.18 0.17 0.11 / 0.11 0.19 0.12 0.15",
    ("lugre_static", "rms", 0.010): "0.068 0.081 0.075 0.06 / 0.045 0.077 0.066 0.047 / 0.041 0.075 0.058 0.062",
    ("lugre_dynamic", "max", 0.010): "0.13 0.14 0.13 0.12 / 0.07 0.13 0.1 0.09 / 0.07 0.11 0.13 0.09",
    ("lugre_dynamic", "rms", 0.010): "0.067 0.068 0.067 0.056 / 0.03 0.049 0.037 0.04 / 0.032 0.051 0.042 0.041",
    ("none", "max", 0.040): "0.5 0.63 0.91 0.58 / 0.41 0.35 0.38 0.46 / 0.31 0.28 0.35 0.36",
    ("none", "rms", 0.040): "0.362 0.324 0.41 0.343 / 0.187 0.188 0.206 0.209 / 0.12 0.141 0.14 0.147",
    ("lugre_static", "max", 0.040): "0.48 0.52 0.93 0.59 / 0.2 0.3 0.32 0.23 / 0.14 0.25 0.18 0.2",
    ("lugre_static", "rms", 0.040): "0.307 0.263 0.378 0.28 / 0.109 0.133 0.133 0.117 / 0.066 0.115 0.084 0.083",
    ("lugre_dynamic", "max", 0.040): "0.55 0.58 0.89 0.65 / 0.17 0.24 0.31 0.24 / 0.15 0.2 0.17 0.21",
    ("lugre_dynamic", "rms", 0.040): "0.309 0.281 0.374 0.289 / 0.09 0.131 0.131 0.111 / 0.063 0.103 0.075 0.077",
}
POSITIONS = ("p1", "p2", "p3", "p4")


@pytest.mark.parametrize(("method", "statistic", "speed"), TABLES)
def test_numbers_are_those_of_the_thesis(method, statistic, speed):
    printed = [[float(x) for x in row.split()] for row in TABLES[method, statistic, speed].split("/")]
    found = [[published_mm(method, statistic, speed, radius, p) for p in POSITIONS] for radius in RADII]
    assert found == printed


@pytest.mark.parametrize("method", METHODS)
def test_nothing_was_published_at_100_mm_s(method):
    assert published_mm(method, "rms", 0.100, 0.001, "p1") is None


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("speed", [0.010, 0.040])
def test_no_rms_is_above_its_maximum(method, speed):
    for radius in RADII:
        for position in POSITIONS:
            rms, largest = (published_mm(method, statistic, speed, radius, position) for statistic in ("rms", "max"))
            assert (rms is None) == (largest is None)
            assert rms is None or 0 < rms < largest


def test_what_is_in_no_table_is_none():
    assert published_mm("none", "rms", 0.02, 0.001, "p1") is None
    assert published_mm("none", "rms", 0.01, 0.002, "p1") is None
    assert published_mm("none", "rms", 0.01, 0.001, "p5") is None


def test_the_friction_records_are_those_of_table_6_1_but_for_the_misprint():
    table = {record.number: (record.amplitude, record.frequency) for record in FRICTION_RECORDS}
    assert [*table] == [*range(1, 16)]
    assert table[1] == (1.3, 0.25)
    assert table[10] == (5.0, 5.0)
    assert table[11] == (10.0, 0.25)  # printed as 5; figure 6.5e has 10
    assert table[15] == (10.0, 5.0)
    assert len({*table.values()}) == 15
    assert {*ESTIMATION_RECORDS} < {*table}

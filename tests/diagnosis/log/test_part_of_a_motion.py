"""Logs that begin at any time of their clock, or are part of a motion, are diagnosed as the whole one is."""

from dataclasses import replace

import pytest

from ffgym.diagnosis import diagnose
from ffgym.recordings import Recording
from tests.logs.quality.quality_logs import clean_log, described

ROBOT, MOTION = "one_axis", "multisine"


def on_a_later_clock(recording, seconds):
    phases = tuple(replace(p, start=p.start + seconds, end=p.end + seconds) for p in recording.header.phases)
    columns = dict(recording.columns) | {"timestamp": recording.t + seconds}
    return Recording(columns, replace(recording.header, phases=phases))


@pytest.mark.parametrize(
    "part",
    [
        lambda whole: on_a_later_clock(whole, 1000.0),
        lambda whole: whole.slice(end=6.7263),
        lambda whole: whole.slice(start=2.0),
    ],
    ids=["later clock", "cut short", "begun late"],
)
def test_nothing_is_found_in_any_part_of_a_clean_log(part):
    recording = part(clean_log(ROBOT, MOTION))
    assert recording.header.phases
    assert diagnose(described(ROBOT, MOTION), [recording]).verdict == "none"

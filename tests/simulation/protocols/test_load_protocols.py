"""Protocols by name, from motion files, and from files that list steps."""

from contextlib import suppress
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.simulation.protocols import PROTOCOLS, load_protocols, plan_session
from ffgym.simulation.protocols.load import MotionFile
from tests.simulation.protocols.protocol_samples import arm_of

STEPS = """
[[step]]
protocol = "speed_ladder"
joints = ["j1"]
speeds = [1.0, 5.0]

[[step]]
motion = "sine"
repeats = 2
pause = 60.0

[[step]]
motion = "own.toml"
"""
OWN = '[[part]]\nkind = "triangle"\namplitude = "0.1 %"\nperiod = 1.0\n'
PROGRAM_WITH_TOOL = """
MODULE job
  PERS tooldata head := [TRUE, [[0, 0, 100], [1, 0, 0, 0]], [5, [0, 0, 50], [1, 0, 0, 0], 0, 0, 0]];
  PROC main()
    MoveAbsJ [[0, 20, 10, 0, 31, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v100, fine, head;
    MoveAbsJ [[1, 20, 10, 0, 31, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v100, fine, head;
  ENDPROC
ENDMODULE
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", PROTOCOLS)
def test_a_name_gives_the_protocol_with_its_defaults(name):
    (protocol,) = load_protocols(name)
    assert type(protocol) is PROTOCOLS[name]


def test_a_file_of_steps_lists_protocols_and_motions_with_their_settings(here):
    folder = here / "job"
    folder.mkdir()
    (folder / "day.toml").write_text(STEPS)
    (folder / "own.toml").write_text(OWN)
    motions = plan_session(arm_of("one_axis"), load_protocols("job/day.toml"))
    assert [m.reference.name for m in motions] == ["speed_ladder.j1", "motion.sine.1", "motion.sine.2", "motion.own"]
    assert motions[1].start == pytest.approx(motions[0].end + 60.0)
    assert motions[3].start == pytest.approx(motions[2].end + 5.0)


@pytest.mark.parametrize("suffix", [".toml", ".csv"])
def test_a_motion_file_is_a_protocol_of_one_motion(here, suffix):
    table = "t,j1\n[s],[rad]\n0.0,0.0\n1.0,0.5\n2.0,0.0\n"
    (here / f"own{suffix}").write_text(OWN if suffix == ".toml" else table)
    (protocol,) = load_protocols(f"own{suffix}")
    assert type(protocol) is MotionFile
    assert protocol.file == Path(f"own{suffix}")


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("ladder", "Unknown protocol 'ladder'. Available: circles, diagnosis"),
        ("day.txt", r"day.txt: a file of motions must end in .toml, .csv, .mod, .prg"),
        ("job/day", "job/day: a file of motions must end in"),
        ("none.toml", "none.toml: cannot be read"),
        ("step = 3", "step must be tables"),
        ("step = []", "step must be tables"),
        ("[[step]]\nprotocol = 'circles'\n[other]", "unknown entries other"),
        ("[[step]]", r"step 1: a step needs either protocol = a name, or motion"),
        ("[[step]]\nprotocol = 'circles'\nmotion = 'sine'", "step 1: a step needs either"),
        ("[[step]]\nprotocol = 'ladder'", "step 1: Unknown protocol 'ladder'"),
        ("[[step]]\nprotocol = 'holds'\nspeed = 1", "step 1: Unknown settings speed. Protocol holds has"),
        ("[[step]]\nprotocol = 'holds'\npause = 'x'", "step 1: pause must be a number"),
        ("[[step]]\nmotion = 3", "step 1: motion = 3 must be the name"),
        ("[[step]]\nmotion = 'sine'\nfile = 'x.toml'", "says the same as motion = 'sine'"),
        ("[[step]", "is not valid TOML"),
        ("[[step]]\nprotocol = ['a']", r"step 1: Unknown protocol \['a'\]"),
        ("[[step]]\nprotocol = 'holds'\njoints = 3", "joints = 3 must be a list"),
    ],
)
def test_what_makes_no_sense_is_one_error_with_the_file_and_the_step(here, source, message):
    if "step" in source:
        (here / "day.toml").write_text(source)
        source = "day.toml"
    with pytest.raises(FFGymError, match=message) as caught:
        load_protocols(source)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "message"),
    [({"file": "tango"}, "Unknown motion 'tango'"), ({"file": "sine", "repeats": 0}, "repeats = 0")],
)
def test_a_motion_that_makes_no_sense_is_refused(settings, message):
    with pytest.raises(FFGymError, match=f"Protocol motion on 'one_axis': {message}"):
        MotionFile(**settings).schedule(arm_of("one_axis"))


def test_a_program_that_brings_its_own_tool_is_refused(here):
    (here / "job.mod").write_text(PROGRAM_WITH_TOOL)
    with pytest.raises(FFGymError, match="brings its own tool"):
        plan_session(arm_of("irb4600_60_205"), load_protocols("job.mod"))


@pytest.mark.parametrize("name", PROTOCOLS)
@pytest.mark.parametrize("value", ["x", ["x"], [[1.0]], -1, 0, np.nan, {}, None, True], ids=repr)
def test_a_setting_of_any_kind_is_taken_or_refused(name, value):
    for setting in fields(PROTOCOLS[name]):
        with suppress(FFGymError):
            PROTOCOLS[name].parse({setting.name: value}).schedule(arm_of("one_axis"))

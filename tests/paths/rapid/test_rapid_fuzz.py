"""Programs that nobody wrote on purpose are read or refused with one error; nothing else happens, and nothing hangs."""

import re

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from rapid_samples import GOLDEN

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import parse_program
from ffgym.paths.rapid.scope import MOST_LISTED
from ffgym.paths.rapid.syntax import decode
from ffgym.paths.rapid.tokens import RESERVED

TOKEN = re.compile(r'"[^"\n]*"|![^\n]*|[A-Za-z_]\w*|[0-9.]+(?:[eE][+-]?[0-9]+)?|:=|\S|\s+')
WORDS = [
    *sorted(RESERVED),
    *("MoveL", "MoveC", "MoveJ", "MoveAbsJ", "WaitTime", "Offs", "RelTool", "robtarget", "num", "p", "v10", "fine"),
    *("z10", "tool0", "tRobot", "main", ":=", ";", ",", "[", "]", "(", ")", "\\", "+", "-", "*", "/", ".", "{", '"'),
    *("num", "IF", "THEN", "ENDIF", "FOR", "i", "SetDO", "do1", "<", "=", "{", "}", "?", "robtarget", "SetDO", "PROC"),
    *("1", "-0", "9E9", "1E99", "0", "!", "%%%", "\n", "\x00", "\u00e4"),
]

soups = st.lists(st.sampled_from(WORDS), max_size=60).map(" ".join)


def refused(robot, text):
    """Message of the error that a program ends in; empty if it runs."""
    try:
        parse_program(text, "fuzz.mod").execute(robot)
    except FFGymError as error:
        return str(error)
    return ""


def check(robot, text):
    message = refused(robot, text)
    lines = message.split("\n") if message else []
    assert len(lines) <= MOST_LISTED + 1
    for line in lines:
        assert re.match(r"fuzz\.mod:(\d+:\d+:)? |\.\.\. and \d+ more errors", line), message
        assert len(line) < 1000


@st.composite
def mutants(draw):
    """A golden program with tokens deleted, doubled, swapped or replaced."""
    tokens = TOKEN.findall(draw(st.sampled_from(list(GOLDEN.values()))))
    for _ in range(draw(st.integers(1, 4))):
        i, j = (draw(st.integers(0, len(tokens) - 1)) for _ in range(2))
        change = draw(st.sampled_from(["delete", "double", "swap", "replace"]))
        if change == "delete":
            tokens[i] = ""
        elif change == "double":
            tokens[i] *= 2
        elif change == "swap":
            tokens[i], tokens[j] = tokens[j], tokens[i]
        else:
            tokens[i] = draw(st.sampled_from(WORDS))
    return "".join(tokens)


@pytest.mark.parametrize("count", [500, pytest.param(5000, marks=pytest.mark.slow)])
def test_random_bytes_random_words_and_mutants_give_moves_or_one_error(irb4600, count):
    @settings(max_examples=count, suppress_health_check=list(HealthCheck))
    @given(st.one_of(st.binary(max_size=300).map(decode), soups, mutants()))
    @example("PROC main() MoveL p:=1;")
    @example("\ufeff")
    @example("\x00\x1a" * 50)
    def run(text):
        check(irb4600, text)

    run()


@pytest.mark.parametrize("text", GOLDEN.values(), ids=list(GOLDEN))
def test_a_program_that_is_cut_off_anywhere_is_refused(irb4600, text):
    whole = text.rstrip()
    for end in range(0, len(whole), 7):
        message = refused(irb4600, whole[:end])
        assert message.startswith("fuzz.mod:")


@pytest.mark.parametrize("text", GOLDEN.values(), ids=list(GOLDEN))
def test_a_program_without_one_of_its_tokens_runs_or_is_refused(irb4600, text):
    tokens = TOKEN.findall(text)
    for i in range(0, len(tokens), 3):
        check(irb4600, "".join(tokens[:i] + tokens[i + 1 :]))


@pytest.mark.parametrize(
    "piece", ["(", "[", "-", "p.", "\\a", "x(", "1+", "!", '"', "%%%", "PROC ", "a;", "\n", "\u00e4"]
)
def test_long_repetitions_come_to_an_end_quickly(irb4600, piece):
    check(irb4600, piece * 4_000)
    check(irb4600, f"PROC main() WaitTime {piece * 4_000}; ENDPROC")

"""Every public function that reads a file, a text or bytes is one of those of the harness, or listed with a reason."""

import ast
import os
import re
from pathlib import Path

import ffgym
from ffgym.logs.log_format import LogFormat, log_formats
from scripts.fuzz.groups import load_readers

ROOT = Path(ffgym.__file__).parent
NAME = re.compile(r"(load|read|parse|decode|unpack|open|resolve)(_|$)")
"""Names of functions that read."""
TYPE = re.compile(r"\b(Path|PathLike|bytes)\b")
"""Types of what they read; text comes as an argument of one of the names below."""
TEXTS = ("text", "data", "document")

LEFT_OUT = {
    "ffgym.agents.residual.training.read_checkpoint": "written by torch, which loads weights alone; "
    "tests/agents/residual/test_training_resume.py damages it",
    "ffgym.core.files.read_arrays": "read by recording_by_column",
    "ffgym.core.files.read_bytes": "read by every reader",
    "ffgym.core.files.read_text": "read by every reader",
    "ffgym.core.toml.parse_toml": "read by every reader of TOML",
    "ffgym.deployment.streams.ports.parse_address": "an address of a command line, not a file",
    "ffgym.deployment.streams.validity.Order.read": "asks a wire, whose packets are damaged",
    "ffgym.deployment.streams.wire.Wire.decode_command": "a protocol without code",
    "ffgym.deployment.streams.wire.Wire.decode_feedback": "a protocol without code",
    "ffgym.leaderboard.submission.entrant.load_submission": "decode_submission, then a process for the agent, whose "
    "faults are those of foreign code",
    "ffgym.leaderboard.submission.python_agent.load": "runs the code of an agent in a process of its own",
    "ffgym.paths.rapid.reader.read": "read by load_program",
    "ffgym.paths.rapid.syntax.decode": "read by load_program",
    "ffgym.simulation.export.play.read_recording": "a script of its own in a bundle, which reads the file beside it",
}
"""Functions that no reader of the harness names, and the reason."""


def sources() -> list[Path]:
    """Files of the package, through links between its folders."""
    return [
        Path(place, name) for place, _, names in os.walk(ROOT, followlinks=True) for name in names if name[-3:] == ".py"
    ]


def takes_a_file(function: ast.FunctionDef) -> bool:
    """Whether an argument is a path, bytes or a text."""
    every = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return any(
        (arg.annotation is not None and TYPE.search(ast.unparse(arg.annotation))) or arg.arg in TEXTS for arg in every
    )


def public_readers() -> set[str]:
    """Functions and methods of the package, outside its command line, that read."""
    found = set()
    for file in sources():
        place = file.relative_to(ROOT.parent).with_suffix("")
        if "cli" in place.parts:
            continue
        module = ".".join(place.parts)
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            owner = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
            for function in node.body if isinstance(node, ast.ClassDef) else [node]:
                if isinstance(function, ast.FunctionDef) and NAME.match(function.name) and takes_a_file(function):
                    found.add(f"{module}.{owner}{function.name}")
    return {name for name in found if "._" not in name}


def covered() -> set[str]:
    """What the readers of the harness say that they go through."""
    functions = {function for readers in load_readers().values() for one in readers for function in one.covers}
    names = {f"{function.__module__}.{function.__qualname__}" for function in functions}
    # formats of logs are found by their class, and read by one function
    formats = [LogFormat, *(type(kind) for kind in log_formats() if type(kind).__module__.startswith("ffgym."))]
    return names | {f"{kind.__module__}.{kind.__name__}.{how}" for kind in formats for how in ("read", "decode")}


def test_every_public_reader_is_in_the_harness_or_in_the_list_of_exceptions():
    readers = public_readers()
    assert len(readers) > 60
    assert readers - covered() - LEFT_OUT.keys() == set()


def test_the_list_of_exceptions_names_what_is_there_and_nothing_that_is_covered():
    assert LEFT_OUT.keys() <= public_readers()
    assert not LEFT_OUT.keys() & covered()


def test_json_and_toml_are_parsed_in_one_place_each():
    found = {
        file.relative_to(ROOT).as_posix()
        for file in sources()
        if re.search(r"\bjson\.loads?\(", file.read_text(encoding="utf-8"))
    }
    assert found == {
        "agents/law_files.py",  # of what it has just written
        "agents/residual/training.py",  # of what it has just written
        "core/claims.py",  # of who made a claim
        "core/typed_json.py",
        "envs/fingerprint.py",  # of the package
        "logs/formats/json_table.py",  # one value, or one a line
        "logs/formats/npz.py",
        "published/thesis.py",  # of the package
        "recordings/header.py",  # of what it has just written
        "simulation/export/play.py",  # a script of its own
    }

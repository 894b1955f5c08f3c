"""A feed-forward law as files of C99, compared with the simulation before they are written."""

import os
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ffgym.control import CausalLaw, FeedForwardLaw, Window
from ffgym.core.errors import FFGymError
from ffgym.core.files import csv_rows, new_folder, write_text
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.deployment.code.compiler import UNCHECKED, compile_c, need_compiler
from ffgym.deployment.code.rolling import Output, count_gathered, literal, write_step
from ffgym.deployment.code.tracing import TracedLaw, no_form, tabulate_program, trace_law
from ffgym.paths import Reference
from ffgym.simulation.plant.compiled.tracing import Untraceable

TOLERANCE = 1e-9
"""Largest difference from the simulation, as a share of the law's largest torque along the motion."""
_REPETITIONS = 10
"""Runs of the check over the motion; the time of a sample is the shortest of them."""


@dataclass(frozen=True, kw_only=True)
class CodeCheck:
    """Comparison of a law in C with the simulation, along its motion."""

    largest_difference: float
    """Largest difference of a torque [N m]."""
    largest_torque: float
    """Largest torque of the law [N m]."""
    worst_us: float
    """Time of the slowest sample, the shortest of several runs over the motion [us]."""
    median_us: float
    """Likewise of the median sample [us]."""
    longest_us: float
    """Longest step of all runs, interruptions by the operating system included [us]."""

    @property
    def agrees(self) -> bool:
        """True if the largest difference is within the tolerance."""
        return self.largest_difference <= TOLERANCE * self.largest_torque


def write_law_code(
    law: FeedForwardLaw, reference: Reference, path: str | os.PathLike[str], *, name: str = "law", checked: bool = True
) -> CodeCheck | None:
    """Write a folder with a law in C99: `law.h`, `law.c`, and `check.c`, which compares it along `reference.csv`.

    Args:
        law: law that runs sample by sample.
        reference: motion of the program that the law is for.
        path: a folder that is empty or does not exist.
        name: begin of the names of files and functions.
        checked: False writes files that are not compared, and say so.

    Returns:
        The comparison with the simulation; None where it was not asked for.

    Raises:
        FFGymError: if the law has no form in C, there is no compiler, or the torques differ; nothing is written then.
    """
    files, tolerance = write_law_files(law, reference, name, checked=checked)
    check = None
    if checked:
        compiler = need_compiler(f"Law {law.name!r} in C")
        with TemporaryDirectory() as folder:
            _write_files(Path(folder), files)
            check = _run_check(compiler, Path(folder), name, tolerance)
        if not check.agrees:
            raise FFGymError(
                f"Law {law.name!r} in C differs from the simulation by {check.largest_difference:.3g} N m along "
                f"{reference.name}, may by {tolerance:.3g}; nothing is written. "
                "Please report it, with robot and motion."
            )
    with new_folder(path) as folder:
        _write_files(folder, files)
    return check


def write_law_files(
    law: FeedForwardLaw, reference: Reference, name: str, *, checked: bool
) -> tuple[dict[str, str], float]:
    """Write the text of all files of a law in C, by name, and the tolerance of its torques [N m].

    Raises:
        FFGymError: if the law has no form in C, or the name is none in C.
    """
    check_name(name)
    if not isinstance(law, CausalLaw):
        raise FFGymError(
            f"Law {law.name!r} does not run sample by sample, so that it has no code; its torques along one motion can "
            "be written as a table: ffgym export table."
        )
    traced = trace_law(law, reference)
    torque = law.torque(reference)
    tolerance = TOLERANCE * float(np.abs(torque).max())
    known = _describe(traced, reference, name) | {
        "checked": f"Compared with the simulation along {reference.name} when it was written."
        if checked
        else UNCHECKED,
        "tolerance": f"{tolerance!r} /* N m: {TOLERANCE:g} of the largest torque along the motion */",
        "repetitions": str(_REPETITIONS),
    }
    files = {file: _fill(template, known) for file, template in _files(name).items()}
    return files | {"reference.csv": _reference_text(reference, torque)}, tolerance


def check_name(name: str) -> None:
    """Raise if a name cannot begin names of C functions."""
    if re.fullmatch(r"[a-z][a-z0-9_]*", name) is None or name == "check":
        raise FFGymError(
            f"name = {name!r} must be lower-case letters, digits and _, and not 'check', as it begins names of C "
            "functions and files."
        )


def _files(name: str) -> dict[str, str]:
    return {f"{name}.h": "law.h", f"{name}.c": "law.c", "check.c": "check.c"}


def _fill(template: str, known: dict[str, str]) -> str:
    text = (resources.files("ffgym.deployment.code") / "templates" / template).read_text(encoding="utf-8")
    return Template(text).substitute(known)


def _describe(traced: TracedLaw, reference: Reference, name: str) -> dict[str, str]:
    """Collect what the templates leave open."""
    law, robot = traced.law, reference.robot
    start = law.initial_memory(Window.along(reference, law.preview)[0])
    try:
        tables, statements = write_step(_outputs(traced), law.n_joints)
    except Untraceable as error:
        raise no_form(law, error) from error
    program: list[str] = []
    scope = f"for motions that start as {reference.name} does" if start.any() else "for any motion"
    if traced.terms:
        scope = f"for the program {reference.name} alone"
        table = tabulate_program(traced, reference)
        tables.append(_table_text(table))
        program = _program_text(len(table), law.n_joints)
    return {
        "title": f"{law.name} on {robot.name}",
        "name": name,
        "upper": name.upper(),
        "law": law.name,
        "robot": robot.name,
        "version": __version__,
        "scope": scope,
        "end": " After the end of the program it returns 1, and a torque of 0." if traced.terms else "",
        "dt": repr(traced.dt),
        "preview": str(law.preview),
        "joints": str(law.n_joints),
        "memory": str(max(len(start), 1)),
        "samples": str(len(reference.t)),
        "start": ", ".join(map(repr, start.tolist())) or "0.0",
        "tables": "\n".join(tables),
        "program": _indent(program),
        "statements": _indent(statements),
    }


def _program_text(steps: int, n: int) -> list[str]:
    """Statements that find the row of the program, and end with it."""
    return [
        f"const double *const program = terms[state->step < {steps} ? state->step : 0];",
        f"if (state->step >= {steps}) {{",
        f"    memset(torque, 0, {n} * sizeof torque[0]);",
        "    return 1;",
        "}",
    ]


def _indent(lines: Sequence[str]) -> str:
    return "\n".join(f"    {line}" for line in lines)


def _outputs(traced: TracedLaw) -> list[Output]:
    """Rows of results: the torque, and the memory joint by joint, in whichever order of it joints are alike."""
    n, memory = traced.law.n_joints, traced.memory
    torque = Output("torque", 0, 1, traced.torque)
    rows = len(memory) // n
    if rows * n != len(memory):
        return [torque, *(Output("next", k, 1, (node,) * n) for k, node in enumerate(memory))]
    last = [torque, *(Output("next", r * n, 1, memory[r * n : (r + 1) * n]) for r in range(rows))]
    first = [torque, *(Output("next", r, rows, memory[r::rows]) for r in range(rows))]
    return min(last, first, key=count_gathered)


def _table_text(table: Array) -> str:
    """Terms of the program as a table of C."""
    rows = ",\n".join("    {" + ", ".join(map(literal, row)) + "}" for row in table.tolist())
    head = f"static const double terms[{len(table)}][{table.shape[1]}]"
    return f"/* Torque of the rigid links along the program, a row for each step. */\n{head} = {{\n{rows}}};"


def _reference_text(reference: Reference, torque: Array) -> str:
    """Reference and torques of the simulation as CSV."""
    parts: dict[str, Any] = {
        "q": reference.q,
        "motor_dq": reference.motor_dq,
        "motor_ddq": reference.motor_ddq,
        "torque": torque,
    }
    names = [f"{part}.{joint}" for part in parts for joint in reference.robot.joints]
    return ",".join(names) + "\n" + csv_rows(np.concatenate([*parts.values()], axis=1))


def _write_files(folder: Path, files: dict[str, str]) -> None:
    for file, text in files.items():
        write_text(folder / file, text)


def _run_check(compiler: str, folder: Path, name: str, tolerance: float) -> CodeCheck:
    """Compile and run the check."""
    program = folder / "check"
    compile_c(compiler, [folder / f"{name}.c", folder / "check.c"], program)
    done = subprocess.run([program, folder / "reference.csv"], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise FFGymError(f"The check of the law in C fails: {done.stderr.strip() or done.returncode}.")
    found = {key: float(value) for key, value in (line.split() for line in done.stdout.splitlines())}
    return CodeCheck(
        largest_difference=found["largest_difference_Nm"],
        largest_torque=tolerance / TOLERANCE,
        worst_us=found["worst_us"],
        median_us=found["median_us"],
        longest_us=found["longest_us"],
    )

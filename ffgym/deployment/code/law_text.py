"""Text of the files of a law in C99."""

from collections.abc import Sequence

import numpy as np

from ffgym.control import Window
from ffgym.core.files import csv_rows
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.deployment.code.compiler import fill_template
from ffgym.deployment.code.rolling import Output, count_gathered, literal, write_step
from ffgym.deployment.code.tracing import TracedLaw, no_form, tabulate_program
from ffgym.paths import Reference
from ffgym.simulation.plant.compiled.tracing import Node, Untraceable

QUANTITIES = ("torque", "own_position", "own_speed", "instant_position", "instant_speed")
"""What a law in C computes, in the order in which it is compared."""


def law_files(
    traced: TracedLaw,
    reference: Reference,
    wanted: Sequence[Array],
    *,
    name: str,
    checked: str,
    share: float,
    repetitions: int,
) -> dict[str, str]:
    """Write the text of each file, by its name.

    Args:
        traced: the law.
        reference: motion of the program.
        wanted: QUANTITIES along it, as the simulation has them, (T, N) each.
        name: begin of the names of files and functions.
        checked: sentence that says whether it was compared.
        share: largest difference as a share of the largest number of a quantity.
        repetitions: runs of the check.

    Raises:
        FFGymError: if the law has no form in C.
    """
    known = _describe(traced, reference, name) | {
        "checked": checked,
        "share": f"{share:g}",
        "tolerances": ", ".join(repr(share * float(np.abs(values).max())) for values in wanted),
        "repetitions": str(repetitions),
    }
    files = {f"{name}.h": "law.h", f"{name}.c": "law.c", "check.c": "check.c"}
    found = {file: fill_template(template, known) for file, template in files.items()}
    return found | {"reference.csv": _reference_text(reference, wanted)}


def _describe(traced: TracedLaw, reference: Reference, name: str) -> dict[str, str]:
    """Collect what the templates leave open."""
    law, robot = traced.law, reference.robot
    start = law.initial_memory(Window.along(reference, law.preview)[0])
    try:
        tables, statements = write_step(_outputs(traced), law.n_joints)
        own, instant = (write_step(_errors(each), law.n_joints) for each in (traced.own_error, traced.instant_error))
    except Untraceable as error:
        raise no_form(law, error) from error
    terms, program = "", list[str]()
    scope = f"for motions that start as {reference.name} does" if start.any() else "for any motion"
    if traced.terms:
        scope = f"for the program {reference.name} alone"
        table = tabulate_program(traced, reference)
        terms = _table_text(table)
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
        "terms": terms,
        "tables": _indent(tables),
        "program": _indent(program),
        "statements": _indent(statements),
        "own_tables": _indent(own[0]),
        "own_statements": _indent(own[1]),
        "instant_tables": _indent(instant[0]),
        "instant_statements": _indent(instant[1]),
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


def _errors(error: tuple[tuple[Node, ...], tuple[Node, ...]]) -> list[Output]:
    """Rows of results: an error of position and one of speed."""
    return [Output("position", 0, 1, error[0]), Output("speed", 0, 1, error[1])]


def _table_text(table: Array) -> str:
    """Terms of the program as a table of C."""
    rows = number_rows(table)
    head = f"static const double terms[{len(table)}][{table.shape[1]}]"
    return f"/* Torque of the rigid links along the program, a row for each step. */\n{head} = {{\n{rows}}};"


def number_rows(table: Array) -> str:
    """Rows of numbers of a table in C."""
    return ",\n".join("    {" + ", ".join(map(literal, row)) + "}" for row in table.tolist())


def _reference_text(reference: Reference, wanted: Sequence[Array]) -> str:
    """Reference, and what the simulation has along it, as CSV."""
    parts = {"q": reference.q, "motor_dq": reference.motor_dq, "motor_ddq": reference.motor_ddq}
    parts |= dict(zip(QUANTITIES, wanted, strict=True))
    names = [f"{part}.{joint}" for part in parts for joint in reference.robot.joints]
    return ",".join(names) + "\n" + csv_rows(np.concatenate([*parts.values()], axis=1))

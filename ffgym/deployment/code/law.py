"""A feed-forward law as files of C99, compared with the simulation before they are written."""

import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffgym.control import CausalLaw, FeedForwardLaw, Window
from ffgym.core.errors import FFGymError
from ffgym.core.files import new_folder, write_text
from ffgym.core.temporaries import scratch_folder
from ffgym.core.types import Array
from ffgym.deployment.code.compiler import UNCHECKED, compile_c, need_compiler
from ffgym.deployment.code.law_text import law_files
from ffgym.deployment.code.tracing import trace_law
from ffgym.paths import Reference

TOLERANCE = 1e-9
"""Largest difference from the simulation, as a share of the law's largest torque along the motion."""
_REPETITIONS = 10
"""Runs of the check over the motion; the time of a sample is the shortest of them."""


@dataclass(frozen=True, kw_only=True)
class CodeCheck:
    """Comparison of a law in C with the simulation, along its motion."""

    agrees: bool
    """True if every number is within the tolerance."""
    largest_difference: float
    """Largest difference of a torque [N m]."""
    largest_own_difference: float
    """Largest difference of an error that the law itself asks for [rad]."""
    worst_us: float
    """Time of the slowest sample, the shortest of several runs over the motion [us]."""
    median_us: float
    """Likewise of the median sample [us]."""
    longest_us: float
    """Longest step of all runs, interruptions by the operating system included [us]."""


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
    files = write_law_files(law, reference, name, checked=checked)
    check = check_law_files(files, name, f"Law {law.name!r} in C", reference.name) if checked else None
    with new_folder(path) as folder:
        _write_files(folder, files)
    return check


def write_law_files(law: FeedForwardLaw, reference: Reference, name: str, *, checked: bool) -> dict[str, str]:
    """Write the text of all files of a law in C, by name.

    Raises:
        FFGymError: if the law has no form in C, or the name is none in C.
    """
    check_name(name)
    if not isinstance(law, CausalLaw):
        raise FFGymError(
            f"Law {law.name!r} does not run sample by sample, so that it has no code; its torques along one motion can "
            "be written as a table: ffgym export table."
        )
    said = f"Compared with the simulation along {reference.name} when it was written." if checked else UNCHECKED
    return law_files(
        trace_law(law, reference),
        reference,
        _simulate(law, reference),
        name=name,
        checked=said,
        share=TOLERANCE,
        repetitions=_REPETITIONS,
    )


def _simulate(law: CausalLaw, reference: Reference) -> tuple[Array, ...]:
    """Compute `QUANTITIES` along a reference, (T, N) each; errors step by step, as the code has them."""
    instant = np.zeros((2, *reference.q.shape))
    windows = Window.along(reference, law.preview)
    memory = law.initial_memory(windows[0])
    for k in range(len(reference.t) - 1):
        instant[:, k + 1] = law.instant_error(memory)
        memory = law.step(memory, windows[k])[1]
    return law.torque(reference), *CausalLaw.own_errors(law, reference), *instant


def check_name(name: str) -> None:
    """Raise if a name cannot begin names of C functions."""
    if re.fullmatch(r"[a-z][a-z0-9_]*", name) is None or name == "check":
        raise FFGymError(
            f"name = {name!r} must be lower-case letters, digits and _, and not 'check', as it begins names of C "
            "functions and files."
        )


def _write_files(folder: Path, files: dict[str, str]) -> None:
    for file, text in files.items():
        write_text(folder / file, text)


def check_law_files(files: dict[str, str], name: str, what: str, motion: str) -> CodeCheck:
    """Compile a law and run its check.

    Raises:
        FFGymError: if there is no compiler, or a number differs by more than the tolerance.
    """
    compiler = need_compiler(what)
    with scratch_folder() as folder:
        _write_files(folder, files)
        compile_c(compiler, [folder / f"{name}.c", folder / "check.c"], folder / "check")
        command = [folder / "check", folder / "reference.csv"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise FFGymError(f"The check of {what} fails: {done.stderr.strip() or done.returncode}.")
    found = {key: float(value) for key, value in (line.split() for line in done.stdout.splitlines())}
    check = CodeCheck(
        agrees=done.returncode == 0,
        largest_difference=found["difference_torque_Nm"],
        largest_own_difference=found["difference_own_position_rad"],
        worst_us=found["worst_us"],
        median_us=found["median_us"],
        longest_us=found["longest_us"],
    )
    if not check.agrees:
        raise FFGymError(
            f"{what} differs from the simulation by {check.largest_difference:.3g} N m along {motion}, and by "
            f"{check.largest_own_difference:.3g} rad in the errors that the law asks for, may by {TOLERANCE:g} of the "
            "largest of each; nothing is written. Please report it, with robot and motion."
        )
    return check

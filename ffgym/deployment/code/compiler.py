"""Files of C: templates, and the compiler of this computer, which they are checked with."""

import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from string import Template

from ffgym.core.errors import FFGymError

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off")
"""Options: those that the files themselves name."""
UNCHECKED = "Not compared with the simulation, as its writer asked for."
"""Line in files that were written without a compiler."""


def find_compiler() -> str | None:
    """Find a compiler: the one that the variable CC names, or cc, gcc or clang; None if there is none."""
    names = [os.environ["CC"]] if os.environ.get("CC") else ["cc", "gcc", "clang"]
    return next((path for name in names if (path := shutil.which(name)) is not None), None)


def need_compiler(what: str, *, optional: bool = True) -> str:
    """Return the compiler; `optional` says that files can be written without one.

    Raises:
        FFGymError: if there is none.
    """
    compiler = find_compiler()
    if compiler is None:
        way_out = ", or ask for files that are not compared (--unchecked)" if optional else ""
        raise FFGymError(
            f"{what} is compiled and compared with the simulation before it is written, and there is no C compiler: "
            f"neither the variable CC nor cc, gcc or clang name one. Install one{way_out}."
        )
    return compiler


def compile_c(compiler: str, sources: Sequence[Path], out: Path, *options: str) -> None:
    """Compile C sources to the file `out`.

    Raises:
        FFGymError: if it does not compile.
    """
    command = [compiler, *FLAGS, *options, *map(str, sources), "-lm", "-o", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise FFGymError(f"{sources[0].name} does not compile with {compiler}: {done.stderr.strip()[:500]}")


def fill_template(template: str, known: Mapping[str, str]) -> str:
    """Fill in a file of C that leaves parts open as `$name`."""
    text = (resources.files("ffgym.deployment.code") / "templates" / template).read_text(encoding="utf-8")
    return Template(text).substitute(known)

"""FMUs from their parts: compiled with a face of the standard, and packed."""

import io
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import mujoco

from ffgym.core.files import write_text
from ffgym.core.temporaries import scratch_folder
from ffgym.deployment.code.compiler import compile_c, fill_template
from ffgym.deployment.code.model_description import ModelDescription, Version, description_text

_FOLDERS: Mapping[Version, str] = {"2.0": "linux64", "3.0": "x86_64-linux"}
"""Folders of binaries by version of the standard."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FmuParts:
    """Parts of an FMU."""

    description: ModelDescription
    sources: Mapping[str, str]
    """Text of C files by name, beside those that all FMUs have."""
    libraries: tuple[Path, ...] = ()
    """Shared libraries that are shipped beside the binary."""
    resources: Mapping[str, bytes]
    """Files of the resources by name."""


def build_fmu(parts: FmuParts, version: Version, compiler: str) -> bytes:
    """Compile an FMU and pack it; equal parts give equal bytes, but for those of the compiler."""
    import fmpy

    headers, name = Path(fmpy.__file__).parent / "c-code", parts.description.name
    face = fill_template(f"fmi{version[0]}.c", {})
    sources = dict(parts.sources) | {
        "fmu.h": fill_template("fmu.h", {}),
        "fmu.c": fill_template("fmu.c", {}),
        "face.c": face,
        "fmu_data.c": _data_text(parts.description),
        "rest.c": _rest_text(face, headers / f"fmi{version[0]}Functions.h"),
    }
    includes = (headers, Path(mujoco.__file__).parent / "include")
    options = ["-shared", "-fPIC", "-fvisibility=hidden", "-Wl,-rpath,$ORIGIN", *(f"-I{place}" for place in includes)]
    files = {"modelDescription.xml": description_text(parts.description, version)}
    binaries = f"binaries/{_FOLDERS[version]}"
    with scratch_folder() as folder:
        for file, text in sources.items():
            write_text(folder / file, text)
        code = [folder / file for file in sources if file.endswith(".c")]
        compile_c(compiler, [*code, *parts.libraries], folder / f"{name}.so", *options)
        files[f"{binaries}/{name}.so"] = (folder / f"{name}.so").read_bytes()
    files |= {f"{binaries}/{library.name}": library.read_bytes() for library in parts.libraries}
    files |= {f"resources/{file}": data for file, data in parts.resources.items()}
    if parts.libraries:
        files |= {f"documentation/licenses/{file}": data for file, data in _licenses("mujoco").items()}
    return _pack(files)


def _licenses(package: str) -> dict[str, bytes]:
    """Read the licenses that came with an installed package, which must go with its library."""
    found = [file for file in metadata.files(package) or () if "licenses" in file.parts]
    return {f"{package}_{file.name}": file.read_binary() for file in found}


def _data_text(description: ModelDescription) -> str:
    """Constants of a model in C."""
    variables = description.variables
    starts = ", ".join(repr(variable.start or 0.0) for variable in variables)
    return "\n".join(
        [
            '#include "fmu.h"',
            f'const char fmu_token[] = "{description.token}";',
            f"const size_t fmu_inputs = {description.n_inputs}, fmu_outputs = {len(variables) - description.n_inputs};",
            f"const double fmu_start_values[] = {{{starts}}};\n",
        ]
    )


_QUIET = ("EnterInitializationMode", "Terminate", "SetDebugLogging", "EnterStepMode")
"""Functions of the standard that have nothing to do here."""


def _rest_text(face: str, header: Path) -> str:
    """Functions of the standard that an FMU must have, and this one has no use for."""
    declared = re.findall(r"^\s*FMI\d_Export\s+\w+TYPE\s+(fmi\d(\w+));", header.read_text(encoding="utf-8"), flags=re.M)
    lines = ["#include <stddef.h>", '#define SHOWN __attribute__((visibility("default")))']
    for name, short in declared:
        if re.search(rf"\b{name}\(", face):
            continue
        if short.startswith("Instantiate"):
            lines.append(f"SHOWN void *{name}(void) {{ return NULL; }}")
        elif short in _QUIET:
            lines.append(f"SHOWN int {name}(void) {{ return 0; }}")
        else:  # an error, but for no variables at all
            arguments = "void *c, void *references, size_t n"
            lines.append(f"SHOWN int {name}({arguments}) {{ (void)c, (void)references; return n == 0 ? 0 : 3; }}")
    return "\n".join(lines) + "\n"


def _pack(files: Mapping[str, bytes]) -> bytes:
    """Pack files as a ZIP archive with one date."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED, 1)  # fast
    return buffer.getvalue()

"""What MuJoCo says about a file, as one error of ours."""

import re
import warnings as python_warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco

from ffgym.core.errors import FFGymError
from ffgym.robot.arm_file.mesh_files import WAY_OUT, without_mesh

_WAYS_OUT = (
    (
        "mass and inertia of moving bodies",
        "A link that moves must weigh something, itself or through what is welded to it: give it a mass and an "
        "inertia, or weld it to the link before it",
    ),
    ("inertia must", "No body has such an inertia; take it about the centre of mass, in kg m^2, from the CAD model"),
    ("ASCII file", f"Save the mesh as binary STL, {WAY_OUT}"),
    ("stl_decoder", f"Copy or make the mesh again, {WAY_OUT}"),
    ("obj_decoder", f"Copy or make the mesh again, {WAY_OUT}"),
    ("mesh", f"Repair the mesh, {WAY_OUT}"),
    ("vertices", f"Repair the mesh, {WAY_OUT}"),
    ("find decoder", "Give it a name that ends in .xml"),
    ("Error opening file", "Put the file there"),
)
"""What to do about messages that we foresee; the first that fits is added."""


@contextmanager
def engine_errors(*, line_numbers: bool) -> Iterator[list[str]]:
    """Raise what MuJoCo refuses as an FFGymError; yields the list that its warnings go to.

    Without this, MuJoCo prints its warnings and writes them to MUJOCO_LOG.TXT in the working directory.

    Args:
        line_numbers: whether the lines it names are those of the user's file, and may be shown.
    """
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        with python_warnings.catch_warnings(record=True) as caught:
            python_warnings.simplefilter("always")
            yield said
        said += [_one_line(str(warning.message)) for warning in caught]
    except FFGymError:
        raise
    except (ValueError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        text = str(error) if line_numbers else re.sub(r",? line \d+", "", str(error))
        raise FFGymError(_refusal(text)) from error
    finally:
        mujoco.set_mju_user_warning(before)


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Compile a model with all its bodies, also those that are welded, and with what is only looks.

    Raises:
        FFGymError: if a mesh is missing, or names are no text; what else MuJoCo refuses is left to `engine_errors`.
    """
    spec.compiler.fusestatic = False
    spec.compiler.discardvisual = False
    spec.compiler.usethread = False  # so that warnings come from the thread that holds Python's lock
    try:
        model = spec.compile()
        model.names.decode("utf-8")
    except UnicodeDecodeError as error:
        raise FFGymError("Names in it are not UTF-8 text. Save the file as UTF-8.") from error
    except ValueError as error:
        missing = re.search(r"Error opening file '(.+)'", str(error))
        for mesh in spec.meshes:
            if missing is not None and Path(mesh.file).name == Path(missing[1]).name:
                place = Path(spec.modelfiledir) / missing[1]
                raise FFGymError(
                    f"The mesh {mesh.name!r} is missing; looked for {place}. Put it there, {without_mesh(spec, mesh)}."
                ) from error
        raise
    return model


def _refusal(message: str) -> str:
    text = re.sub(r"^((XML )?Error: )+", "", _one_line(message)).rstrip(".;:")
    ways = [way for sign, way in _WAYS_OUT if sign in text]
    return f"MuJoCo refuses it: {text}." + (f" {ways[0]}." if ways else "")


def _one_line(message: str) -> str:
    return "; ".join(line.strip() for line in message.splitlines() if line.strip())

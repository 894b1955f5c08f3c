"""Where the meshes of a URDF file are."""

from pathlib import Path

from ffgym.errors import FFGymError

READABLE = (".stl", ".obj", ".msh")
"""Formats that MuJoCo reads."""

WAY_OUT = 'or leave the looks out: --no-looks of ffgym robot new, looks = "none" in [robot], looks=False in read_arm'
"""What helps against any trouble with a mesh."""


def find_mesh(uri: str, folder: Path, what: str) -> Path:
    """The file that `uri` means in a file that lies in `folder`.

    `package://name/rest` is looked for as `name/rest` in every folder that holds the file, `file:///place` is absolute;
    other relative paths start at `folder`.

    Raises:
        FFGymError: if there is no such file; `what` names the mesh.
    """
    places = _places(uri, folder)
    for place in places:
        if place.is_file():
            return place
    looked = ", ".join(map(str, places[:3])) + (f" and {len(places) - 3} folders above" if len(places) > 3 else "")
    raise FFGymError(f"The mesh {uri!r} of {what} is missing; looked for {looked}. Put it there, {WAY_OUT}.")


def _places(uri: str, folder: Path) -> list[Path]:
    _, scheme, rest = uri.partition("://")
    return [parent / rest for parent in (folder, *folder.parents)] if scheme else [folder / uri]

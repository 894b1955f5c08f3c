"""Video files that appear whole or not at all."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable
from ffgym.core.provenance import installed

NEEDED = {".mp4": ("imageio", "imageio-ffmpeg"), ".gif": ("imageio", "pillow")}
"""Packages by suffix."""


def check_movie(path: Path) -> None:
    """Check before long work that a video can be written to `path`.

    Raises:
        FFGymError: if its suffix is unknown, a package is missing, or its folder is not writable.
    """
    suffix = path.suffix.lower()
    if suffix not in NEEDED:
        raise FFGymError(f"{path}: a video must end in {' or '.join(NEEDED)}, got {suffix!r}.")
    missing = [name for name in NEEDED[suffix] if not installed(name)]
    if missing:
        raise FFGymError(f"A {suffix} video needs {' and '.join(missing)}; pip install 'ffgym[video]'.")
    check_writable(path)


@contextmanager
def movie(path: Path, fps: float) -> Iterator[Callable[[NDArray[np.uint8]], None]]:
    """Yield a function that appends a picture (H, W, 3); the file is at `path` when the block ends without an error.

    Raises:
        FFGymError: if the file cannot be written.
    """
    target = Path(os.path.realpath(path))  # through a link, as an ordinary write does
    temporary = target.with_name(f".ffgym-{uuid4().hex}{target.suffix.lower()}")
    writer: Any = None
    try:
        writer = _writer(temporary, fps)
        yield lambda picture: writer.append_data(_even(picture))
        writer.close()
        os.replace(temporary, target)
    except OSError as error:
        raise FFGymError(f"{path}: cannot be written: {error}. The folder must have space left.") from error
    finally:
        if writer is not None:
            with suppress(Exception):  # after an error or Ctrl-C; the file goes anyway
                writer.close()
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _writer(path: Path, fps: float) -> Any:
    import imageio.v2 as imageio

    if path.suffix == ".gif":
        return imageio.get_writer(path, duration=1000 / fps, loop=0)
    return imageio.get_writer(path, fps=fps, codec="libx264", quality=8, macro_block_size=1)


def _even(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The picture without a last odd row and column, which video players do not take."""
    return picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2]

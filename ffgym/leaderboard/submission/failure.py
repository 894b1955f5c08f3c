"""What is said of an exception that an agent raised, and where in its file."""

import os
import traceback
from pathlib import Path

from ffgym.core.errors import FFGymError


def failure_text(error: BaseException, folder: Path) -> str:
    """Reason why an agent is refused that raised this; with file and line if it was raised from a file in `folder`."""
    text = " ".join(str(error).split())[:400]
    reason = text if isinstance(error, FFGymError) else f"it raised {type(error).__name__}: {text}"
    lines = [
        f"{Path(frame.f_code.co_filename).name}, line {line}"
        for frame, line in traceback.walk_tb(error.__traceback__)
        if os.path.dirname(frame.f_code.co_filename) == str(folder)
    ]
    return f"{reason} ({lines[-1]})" if lines else reason

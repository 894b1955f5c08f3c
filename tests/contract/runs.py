"""Runs of examples of commands that write, and what they leave."""

import re
import shutil

import pytest

from ffgym.core.provenance import is_installed
from tests.contract.writing_commands import EXAMPLES

CHEAP = ["robot fill", "plan", "export table", "record"]
"""Commands of the usual tests, of each kind of place: a file that is changed, files, a new folder, a filled one."""
MINUTE = rb"\d{4}-\d\d-\d\d \d\d:\d\d UTC"
"""Time that a page says it was written, which differs."""
TENSORBOARD = "tensorboard"
"""Folder of a training whose files have times in their names."""


def begin(killing, name):
    """Make the working directory of an example anew."""
    shutil.rmtree(killing.folder)
    killing.folder.mkdir()
    for file in EXAMPLES[name].given:
        shutil.copy(killing.place / "stock" / file, killing.folder)


def run(killing, name, *more, **how):
    """Run an example."""
    return killing.run(*name.split(), *EXAMPLES[name].arguments.split(), *more, **how)


def written(killing, name):
    """Bytes of all files of an example by their names, without what may differ; no remains are among them."""
    differs = EXAMPLES[name].differs
    assert not remains(killing)
    files = {
        path.relative_to(killing.folder).as_posix(): path.read_bytes()
        for path in sorted(killing.folder.rglob("*"))
        if path.is_file() and path.parent.name != TENSORBOARD
    }
    return {file: differs(re.sub(MINUTE, b"", data)) for file, data in files.items()}


def remains(killing):
    """List temporary files and folders, and claims."""
    return [path for folder in ("run", "tmp") for path in (killing.place / folder).rglob(".ffgym-*")]


def skip_without(name):
    """Skip where a package or program is missing that an example needs."""
    for needed in EXAMPLES[name].needs:
        if not is_installed(needed) and shutil.which(needed) is None:
            pytest.skip(f"{needed} is not installed")

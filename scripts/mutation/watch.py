"""Which files of tests run which lines of a room, and how long they take: `python -m scripts.mutation.watch`."""

import json
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import coverage
import pytest


class Watch:
    """Plugin of pytest that names the file of tests that runs."""

    def __init__(self, measured: coverage.Coverage) -> None:
        self._measured = measured
        self.times: dict[str, float] = defaultdict(float)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Measure under the name of the test's file."""
        file = item.nodeid.partition("::")[0]
        self._measured.switch_context(file)
        began = time.process_time()  # which a busy machine does not lengthen
        yield
        self.times[file] += time.process_time() - began


def watch(folders: list[str], files: list[str], out: Path) -> int:
    """Run files of tests, and write what runs which line and the processor time of each; return how pytest ended."""
    measured = coverage.Coverage(data_file=None, source=folders, config_file=False)
    plugin = Watch(measured)
    measured.start()
    ended = pytest.main(["-q", "-p", "no:cacheprovider", *files], plugins=[plugin])
    measured.stop()
    data, root = measured.get_data(), Path.cwd()
    lines = {str(Path(file).relative_to(root)): data.contexts_by_lineno(file) for file in data.measured_files()}
    out.write_text(json.dumps({"lines": lines, "times": plugin.times}), encoding="utf-8")
    return int(ended)


if __name__ == "__main__":
    place, folders, files = sys.argv[1], sys.argv[2].split(","), sys.argv[3:]
    sys.exit(watch(folders, files, Path(place)))

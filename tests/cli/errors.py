"""Error of a command, as its user sees it."""


def read_error(capsys) -> str:
    """Return the one line with which a command ended that could not be run."""
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ffgym: error: ")
    return str(line)

"""Progress bars, which terminals alone show."""

import pytest

from ffgym.cli.progress import progress_bar, stages_bar


@pytest.fixture
def on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make rich take the captured error stream for a terminal."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "100")


@pytest.mark.usefixtures("on_a_terminal")
def test_a_bar_is_drawn_on_a_terminal_before_and_after_the_first_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("simulating", "s"):
        pass
    assert "simulating" in capsys.readouterr().err
    with progress_bar("simulating", "s") as progress:
        progress(1.0, 3.0)
    assert "1/3 s" in capsys.readouterr().err


@pytest.mark.usefixtures("on_a_terminal")
def test_stages_are_named_on_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with stages_bar("demo") as tell:
        tell("circles", 0.5)
    assert "circles" in capsys.readouterr().err


def test_no_bar_goes_to_a_file(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    with progress_bar("simulating", "s") as progress:
        progress(1.0, 3.0)
    assert not capsys.readouterr().err

"""The page on trials: its commands print what it says."""

from tests.test_tutorial_with_commands import follow


def test_the_page_leads_from_motions_to_a_gain_with_its_interval(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert follow("../deployment/trial.md", tmp_path, capsys).count("bash") == 3
    assert {"gain.html", "gain.json"} <= {path.name for path in tmp_path.iterdir()}

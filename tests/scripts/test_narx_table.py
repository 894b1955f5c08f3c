"""The table of NARX networks: a row per network beside the static curve, and a page that is renewed."""

import json

from scripts.narx_table import Config, main


def test_the_tables_have_a_row_per_network_and_renew_a_page(tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- fits -->\n<!-- end -->\nb\n<!-- reach -->\nold\n<!-- end -->\nc\n", encoding="utf-8")
    numbers = tmp_path / "numbers.json"
    [fit] = main(Config(candidates=("speeds",), n_starts=1, json=numbers, write=page))
    text = page.read_text(encoding="utf-8")
    assert text.count("| static curve |") == text.count(f"| {fit.candidate.label} |") == 2
    assert "old" not in text
    assert capsys.readouterr().out.strip() in text.replace("<!-- end -->\nb\n<!-- reach -->\n", "\n")
    found = json.loads(numbers.read_text(encoding="utf-8"))
    assert found["config"]["seed"] == 0
    assert found["fits"][0]["errors"]["A = 1, f = 1"]["simulation_rms_nm"] == [fit.rms("A = 1, f = 1")[0]]

"""The script that shows what a perceptron forgets."""

import pytest

from scripts.forgetting import Forgetting, main


@pytest.mark.slow
def test_it_writes_the_figure_and_prints_a_line_per_network(tmp_path, capsys):
    main(Forgetting(out=tmp_path / "forgetting.png"))
    assert (tmp_path / "forgetting.png").read_bytes().startswith(b"\x89PNG")
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["bsn_static", "mlp_fel", "figure:"]

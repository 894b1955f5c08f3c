"""The table of docs/agents/model.md on a small budget, and that the page has a row for each effect it is about."""

import re

from ffgym.agents.model import left_alone
from ffgym.effects import EFFECTS
from ffgym.simulation.plant import Machine
from scripts.model_table import PAGE, Config, main, strong


def test_the_table_is_computed_and_written_between_its_marks(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- effects -->\nold\n<!-- end -->\n", encoding="utf-8")
    table = main(Config(effects=("cogging", "tool_frame"), speeds=(0.1,), radii=(0.003,), write=page))
    assert page.read_text(encoding="utf-8") == f"a\n<!-- effects -->\n{table}\n<!-- end -->\n"
    (row,) = table.splitlines()[2:]
    _, elastic, model = row.strip("| ").split(" | ")
    assert float(model) < 0.6 * float(elastic)


def test_the_page_has_all_effects_that_a_torque_compensates(irb4600):
    (table,) = re.findall(r"<!-- effects -->\n(.*?)\n<!-- end -->", PAGE.read_text(encoding="utf-8"), flags=re.S)
    compensated = [
        name
        for name, effect in EFFECTS.items()
        if not left_alone(Machine(robot=irb4600, effects=(strong(effect, irb4600, 0.5),)))
    ]
    assert re.findall(r"^\| `(\w+)`", table, flags=re.M) == compensated

"""The page on rigid-body identification: its example runs, and it knows every term."""

import re
from pathlib import Path

from ffgym.diagnosis.identification.rigid_body import TERMS

PAGE = (Path(__file__).parents[4] / "docs" / "rigid_body_identification.md").read_text(encoding="utf-8")


def test_the_example_runs(capsys):
    code = "\n".join(re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL))
    exec(compile(code, "docs/rigid_body_identification.md", "exec"), {})
    assert "coulomb.elbow: 0.53" in capsys.readouterr().out


def test_every_term_is_in_the_table():
    table = PAGE.split("## What is fitted")[1].split("**Equations.**")[0]
    assert set(re.findall(r"`(\w+)`(?=[^|]*\|[^|]*\|[^|]*\|$)", table, flags=re.MULTILINE)) >= {t.name for t in TERMS}

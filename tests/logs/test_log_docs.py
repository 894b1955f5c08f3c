"""The page about logs of other tools: its example runs from file to recording."""

import re
from pathlib import Path

from ffgym.cli.main import main
from ffgym.logs import builtin_columns, log_formats, parse_columns

PAGE = (Path(__file__).parents[2] / "docs" / "column_maps.md").read_text(encoding="utf-8")


def test_the_example_runs_with_its_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    first, second, third = re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.M | re.S)
    (command,) = re.findall(r"^```sh\n(.*?)^```", PAGE, flags=re.M | re.S)
    names: dict[str, object] = {}
    exec(first, names)
    assert main(command.split()[1:]) == 0
    assert "pos1" in capsys.readouterr().out
    assert 'source = "time"' in Path("trace_map.toml").read_text(encoding="utf-8")
    exec(second, names)
    exec(third, names)
    assert capsys.readouterr().out.startswith("Recording('press', 'trace', 500 rows, ")
    convert = "log convert trace.csv --columns trace_map.toml --out trace.npz"
    assert convert in PAGE
    assert main(convert.split()) == 0


def test_the_maps_on_the_page_are_valid():
    part, whole = re.findall(r"^```toml\n(.*?)^```", PAGE, flags=re.M | re.S)
    assert parse_columns(part + "[columns.timestamp]\nrate_hz = 5").columns["tcp.position"].resample == "gaps"
    assert parse_columns(whole).robot == "my_robot.toml"


def test_every_format_and_built_in_map_is_on_the_page():
    formats = PAGE.split("## Formats")[1].split("## Column maps that ship")[0]
    shipped = [kind for kind in log_formats() if type(kind).__module__.startswith("ffgym.")]
    assert len(shipped) == 8
    for name in (name for kind in shipped for name in (*kind.suffixes, kind.folder) if name):
        assert f"`{name}`" in formats
    shipped = re.findall(r"^\| `(\w+)` \|", PAGE.split("## Column maps that ship")[1], flags=re.M)
    assert tuple(shipped) == builtin_columns()

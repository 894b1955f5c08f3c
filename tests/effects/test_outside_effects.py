"""Effects of other packages: found by their entry point, simulated, diagnosed, and refused with a reason."""

import json
import re
import shlex
import sys
from pathlib import Path

import pytest

from ffgym.cli.main import main
from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine, Plant
from ffgym.workcell.equations import EQUATIONS
from scripts.exam.equations import OUTSIDERS, VARIANTS

PAGE = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")
SECTION = PAGE.split("## A friction effect")[1].split("\n## ")[0]


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", SECTION, flags=re.S)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Install a package of one module with entry points for effects, for as long as a test runs."""

    def install(module, entry="cover_friction = cover_friction:CoverFriction"):
        site = tmp_path / "site-packages"
        info = site / "cover_effects-1.0.dist-info"
        info.mkdir(parents=True)
        (site / "cover_friction.py").write_text(module, encoding="utf-8")
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: cover-effects\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[ffgym.effects]\n{entry}\n")
        monkeypatch.syspath_prepend(site)

    assert "cover_friction" not in EFFECTS  # which makes the library look for its members
    monkeypatch.delitem(vars(EFFECTS), "_members")
    yield install
    sys.modules.pop("cover_friction", None)


def test_an_effect_of_one_file_elsewhere_has_code(installed):
    installed(blocks("python")[0])
    robot = load_robot("one_axis")
    plant = Plant(Machine(robot=robot, effects=(EFFECTS["cover_friction"].on(robot, share=0.01),)), 1)
    compiled, by_numpy = plant._forces._compiled
    assert compiled is not None
    assert not by_numpy.any()


def test_an_effect_of_one_file_elsewhere_is_simulated_and_diagnosed(installed, tmp_path, monkeypatch, capsys):
    entry_point, machine, session = blocks("toml")
    group, entry = entry_point.strip().splitlines()
    assert group == '[project.entry-points."ffgym.effects"]'
    installed(blocks("python")[0], entry.replace('"', ""))
    monkeypatch.chdir(tmp_path)
    Path("slide.toml").write_text(machine, encoding="utf-8")
    Path("session.toml").write_text(session, encoding="utf-8")
    for command in blocks("bash")[0].strip().splitlines():
        program, *arguments = shlex.split(command)
        assert program == "ffgym"
        assert main(arguments) == 0
    said, (*sentence, row) = capsys.readouterr().out, blocks("text")[0].strip().splitlines()
    assert "\n".join(sentence) in said
    assert row in said
    (cause,) = json.loads(Path("found/diagnosis.json").read_text())["causes"]
    assert cause["effect"] == "cover_friction"
    assert "[effects.cover_friction" in Path("found/extended.toml").read_text().replace('"', "")
    assert list(EFFECTS)[-1] == "cover_friction"


@pytest.mark.parametrize(
    ("change", "entry", "words"),
    [
        (('name: ClassVar[str] = "cover_friction"', 'name: ClassVar[str] = "backlash"'), None, "'backlash'"),
        (('code: ClassVar[str] = "U1"', 'code: ClassVar[str] = "F6"'), None, "'load_friction'"),
        (('code: ClassVar[str] = "U1"', ""), None, r"CoverFriction lacks \['code'\]"),
        (("def torques", "def others"), None, "without abstract methods"),
        (("", ""), "cover_friction = cover_friction:np", "must be a class"),
        (("", ""), "cover_friction = cover_friction:Cover", "AttributeError"),
        (("import numpy as np", "import numpie as np"), None, "No module named 'numpie'"),
    ],
    ids=["name", "code", "no_code", "abstract", "no_class", "missing", "import"],
)
def test_an_entry_point_that_is_no_effect_is_refused_with_its_package(installed, change, entry, words):
    installed(blocks("python")[0].replace(*change), entry or "cover_friction = cover_friction:CoverFriction")
    with pytest.raises(FFGymError, match=f"cover-effects.*{words}"):
        list(EFFECTS)


def test_hidden_equations_are_effects_but_none_of_the_library():
    hidden = {**EQUATIONS, **VARIANTS, **OUTSIDERS}
    assert not set(hidden.values()) & set(EFFECTS.values())
    assert not [kind.name for kind in hidden.values() if kind.code]

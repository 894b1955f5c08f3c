"""The pages of the environments name everything there is, and their code runs."""

import re
from dataclasses import fields
from inspect import signature
from pathlib import Path

import gymnasium as gym
import pytest

from ffgym.core.registration import ENVIRONMENTS
from ffgym.envs import EnvSettings
from ffgym.envs.rewards import REWARDS
from ffgym.envs.start import COMMON_OPTIONS
from ffgym.simulation.plant import PlantDistribution

DOCS = Path(__file__).parent.parent / "docs"
OVERVIEW = (DOCS / "environments" / "README.md").read_text(encoding="utf-8")
PAGES = sorted((DOCS / "environments").glob("*.md")) + sorted((DOCS / "agents").glob("*.md"))


def page_of(name):
    stem = re.sub(r"(?<!^)(?=[A-Z])", "_", name.removeprefix("ffgym/").partition("-v")[0]).lower()
    return (DOCS / "environments" / f"{stem}.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted(ENVIRONMENTS))
def test_every_environment_has_a_page_with_its_arguments_and_options(name):
    page = page_of(name)
    assert page.startswith(f"# {name.partition('-v')[0]}-v0\n")
    assert name in page
    assert name in OVERVIEW
    vector = gym.make_vec(name).unwrapped
    own = set(type(vector).__init__.__kwdefaults__ or {}) - {"autoreset_mode", "render_mode", "max_episode_steps"}
    for keyword in own or signature(vector.tasks).parameters:
        assert f"| `{keyword}` |" in page
    for option in vector.core.tasks.option_names:
        assert f"`{option}`" in page


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_code_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.S):
        exec(compile(block, page.name, "exec"), names)


def test_the_overview_names_every_setting_option_reward_entry_and_layer():
    for setting in fields(EnvSettings):
        assert f"| `{setting.name}` |" in OVERVIEW
    options = OVERVIEW.partition("`reset(options={...})` fixes")[2].partition("\n")[0]
    assert set(re.findall(r"`(\w+)`", options)) == set(COMMON_OPTIONS)
    for reward in REWARDS:
        assert f'"{reward}"' in OVERVIEW
    rows = {line.split("`")[1]: line.split(" | ") for line in OVERVIEW.splitlines() if line.startswith("| `")}
    layout = gym.make("ffgym/CirclePath-v0", preview=0).unwrapped.observation_layout
    for name, entry in layout.items():
        assert rows[name][1:3] == [entry.unit, entry.side]
    info = gym.make("ffgym/CirclePath-v0").reset(seed=0)[1]
    table = OVERVIEW.partition("## Info")[2].partition("## Keyword")[0]
    assert set(
        re.findall(r"`(\w+)`", " ".join(line.split("|")[1] for line in table.splitlines() if "|" in line))
    ) == set(info)


def test_the_overview_names_every_group_of_the_plant_distribution():
    text = OVERVIEW.partition("## Plants that differ")[2].lower()
    for group in fields(PlantDistribution):
        for word in group.name.split("_"):
            assert word in text, group.name


def test_numbers_of_steps_on_the_circle_page_are_those_of_the_environment():
    page = page_of("ffgym/CirclePath-v0")
    env = gym.make("ffgym/CirclePath-v0").unwrapped
    for speed in (0.01, 0.04, 0.1):
        env.reset(seed=0, options={"speed": speed})
        assert f"{env.core.motions[0].n_steps} at {speed * 1e3:g} mm/s" in page

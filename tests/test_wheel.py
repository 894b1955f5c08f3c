"""The built wheel: one top-level package, which lives beside others that are called agents."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

SCRIPT = """
import agents, ffgym, ffgym.agents, gymnasium
assert ffgym.agents.LawAgent.__module__ == "ffgym.agents.law_agent", ffgym.agents.LawAgent.__module__
gymnasium.make("ffgym/OneAxis-v0").reset(seed=0)
print(agents.__file__)
print(ffgym.__file__)
"""


def pip(*arguments):
    subprocess.run([sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments], check=True)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel, built from a copy, so that nothing is left in the repository."""
    source, folder = tmp_path_factory.mktemp("source") / "ffgym", tmp_path_factory.mktemp("wheel")
    leave_out = shutil.ignore_patterns("__pycache__")
    for name in ("ffgym", "agents"):
        shutil.copytree(ROOT / name, source / name, symlinks=True, ignore=leave_out)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    pip("wheel", "--no-deps", "--wheel-dir", str(folder), str(source))
    (path,) = folder.glob("*.whl")
    return path


def test_it_holds_one_package_with_its_agents_and_all_their_files(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"ffgym"}
    assert "ffgym/deployment/code/templates/law.c" in names
    files = [path for path in (ROOT / "agents").rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    assert not {f"ffgym/agents/{path.relative_to(ROOT / 'agents').as_posix()}" for path in files} - set(names)


def test_a_script_beside_a_folder_called_agents_uses_both(wheel, tmp_path):
    pip("install", "--no-deps", "--target", str(tmp_path / "installed"), str(wheel))
    (tmp_path / "project" / "agents").mkdir(parents=True)
    (tmp_path / "project" / "agents" / "__init__.py").touch()
    script = tmp_path / "project" / "main.py"
    script.write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, str(script)],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "installed")},
        capture_output=True,
        text=True,
        check=True,
    )
    agents, ffgym = done.stdout.split()
    assert Path(agents).is_relative_to(tmp_path / "project")
    assert Path(ffgym).is_relative_to(tmp_path / "installed")


@pytest.mark.slow
@pytest.mark.parametrize("first", ["ffgym", "openai-agents"])
def test_it_is_installed_beside_another_package_called_agents_in_either_order(wheel, tmp_path, first):
    subprocess.run([sys.executable, "-m", "venv", str(tmp_path / "env")], check=True)
    python = str(tmp_path / "env" / ("Scripts" if os.name == "nt" else "bin") / "python")
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    both = [str(wheel), "openai-agents"]
    for what in both if first == "ffgym" else reversed(both):
        subprocess.run([python, "-m", "pip", "--quiet", "install", what], env=clean, check=True)
    script = tmp_path / "main.py"
    script.write_text("import agents\nassert agents.Agent and agents.Runner\n" + SCRIPT)
    done = subprocess.run([python, str(script)], cwd=tmp_path, env=clean, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert all(Path(line).is_relative_to(tmp_path / "env") for line in done.stdout.split())


PYTHONS = [sys.executable, *filter(None, os.environ.get("FFGYM_PYTHONS", "").split(os.pathsep))]
"""Interpreters on which the tutorials run from the wheel; FFGYM_PYTHONS names others."""


@pytest.mark.slow
@pytest.mark.parametrize("python", PYTHONS)
def test_readme_and_tutorials_run_from_the_wheel_outside_the_repository(wheel, tmp_path, python):
    subprocess.run([python, "-m", "venv", str(tmp_path / "env")], check=True)
    python = str(tmp_path / "env" / ("Scripts" if os.name == "nt" else "bin") / "python")
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    extras = "rl,plot,cli,logs,report,video,minari,gp,paths"
    what = [f"ffgym[{extras}] @ {wheel.as_uri()}", "pytest", "-c", str(ROOT / "constraints.txt")]
    subprocess.run([python, "-m", "pip", "--quiet", "install", *what], env=clean, check=True)
    outside = tmp_path / "outside"
    shutil.copytree(ROOT / "docs", outside / "docs")
    shutil.copy(ROOT / "README.md", outside)
    (outside / "tests" / "cli").mkdir(parents=True)
    for name in ("test_documentation.py", "test_tutorial_with_commands.py", "cli/test_documented_commands.py"):
        shutil.copy(ROOT / "tests" / name, outside / "tests" / name)
    chosen = "README or tutorials or page_leads or documented"
    run = [python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", chosen, "tests"]
    done = subprocess.run(run, cwd=outside, env=clean, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:]
    assert re.search(r"\b1\d passed", done.stdout)

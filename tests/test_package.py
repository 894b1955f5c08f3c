"""What the package needs, and what importing it loads."""

import re
import subprocess
import sys
from importlib import metadata, resources
from pathlib import Path

import pytest

import ffgym
from ffgym.core.provenance import is_installed, versions

REPOSITORY = Path(__file__).parents[1]
CORE = {"numpy", "scipy", "gymnasium", "mujoco", "threadpoolctl", "lazy-loader"}
EXTRAS = {
    "fast",
    "rl",
    "plot",
    "cli",
    "identify",
    "logs",
    "report",
    "minari",
    "gp",
    "video",
    "cluster",
    "dev",
    "all",
    "paths",
    "tune",
    "streams",
    "mutation",
    "fmu",
    "onnx",
}
OPTIONAL = (
    "onnx",
    "onnxruntime",
    "fmpy",
    "abb_robot_client",
    "cyclonedds",
    "llvmlite",
    "torch",
    "matplotlib",
    "tyro",
    "rich",
    "jinja2",
    "stable_baselines3",
    "tomlkit",
    "pyarrow",
    "h5py",
    "rosbags",
    "cvxpy",
    "ray",
    "minari",
    "imageio",
    "sklearn",
    "lark",
    "ruckig",
    "optuna",
)
MODULES = (
    "simulation",
    "simulation.protocols",
    "studies",
    "envs",
    "recordings",
    "published",
    "core.files",
    "core.provenance",
    "cli",
    "effects",
    "diagnosis.identification",
    "logs",
    "logs.quality",
    "workcell",
)


def requirements():
    """(distribution, its extras, extra that wants it or None) of every requirement."""
    for line in metadata.requires("ffgym"):
        name, extras = re.match(r"([\w-]+)(?:\[([\w,-]+)\])?", line).groups()
        wanted_by = re.search(r"extra == ['\"](\w+)['\"]", line)
        yield name, set((extras or "").split(",")) - {""}, wanted_by and wanted_by[1]


def test_importing_the_core_loads_nothing_optional():
    imports = ", ".join(f"ffgym.{module}" for module in MODULES)
    code = f"import ffgym, {imports}, sys; print([m for m in {OPTIONAL} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    assert done.stderr == ""


def test_making_a_circle_loads_what_it_uses():
    code = "import ffgym, gymnasium, sys; gymnasium.make('ffgym/CirclePath-v0'); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.split()
    unused = (
        "ffgym.effects.catalogue",
        "ffgym.workcell",
        "ffgym.robot.arm_file",
        "ffgym.paths.rapid",
        "scipy.optimize",
    )
    assert not [name for name in loaded if name.startswith(unused)]
    assert len([name for name in loaded if name.startswith("ffgym")]) <= 150


def test_the_core_requires_these_packages():
    assert {name for name, _, extra in requirements() if extra is None} == CORE


def test_there_are_these_extras():
    assert set(metadata.metadata("ffgym").get_all("Provides-Extra")) == EXTRAS


def test_the_extra_all_covers_every_other():
    covered = set().union(*(extras for name, extras, extra in requirements() if extra == "all" and name == "ffgym"))
    assert covered == EXTRAS - {"all"}


def test_the_command_is_installed_with_what_fits_of_masses_and_effects_of_machines_need():
    assert ("ffgym", {"identify", "fast"}, "cli") in list(requirements())


def test_the_command_is_installed():
    (command,) = metadata.entry_points(group="console_scripts", name="ffgym")
    assert command.value == "ffgym.cli:main"


@pytest.mark.parametrize(
    "file",
    [
        "py.typed",
        "robot/data/irb4600_60_205.toml",
        "robot/data/one_axis.toml",
        "published/thesis_tables.json",
        "diagnosis/sessions.toml",
    ],
)
def test_the_package_contains_its_data(file):
    assert resources.files("ffgym").joinpath(*file.split("/")).is_file()


def test_versions_name_everything_that_can_change_a_number():
    assert versions().keys() == {"ffgym", "python", *CORE - {"threadpoolctl", "lazy-loader"}}
    assert versions()["ffgym"] == ffgym.__version__ == metadata.version("ffgym")


def test_installed_tells_without_importing():
    assert is_installed("numpy")
    assert not is_installed("no-such-distribution-at-all")


def test_make_knows_every_target_that_it_lists():
    text = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
    (targets,) = re.findall(r"^\.PHONY: (.*)$", text, flags=re.M)
    assert {"demo", "test", "check", "bench", "exam", "test-all"} <= set(targets.split())
    subprocess.run(["make", "--dry-run", *targets.split()], cwd=REPOSITORY, check=True, capture_output=True)

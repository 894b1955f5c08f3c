"""The `ffgym` command: exit codes, and the demo with its report and numbers."""

import html
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from ffgym.cli.learning_options import Leaderboard
from ffgym.cli.log_options import Diagnose, Identify
from ffgym.cli.main import _MOVED, COMMANDS, load_object, main
from ffgym.cli.motion_options import Demo, Export
from ffgym.core.errors import FFGymError
from ffgym.core.version import __version__
from ffgym.diagnosis import Examination
from ffgym.diagnosis.diagnosis_file import diagnosis_document
from ffgym.diagnosis.resampling import LEVEL, RESAMPLES
from ffgym.diagnosis.settings import settings
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL
from ffgym.leaderboard.tasks import THESIS
from ffgym.robot import ModelOptions, compile_model, load_robot, physics_fingerprint
from ffgym.simulation import RECORD_DT
from tests.cli.errors import read_error
from tests.diagnosis.result_samples import full_diagnosis

ROW_KEYS = {
    "agent", "plant", "position", "radius_mm", "speed_mm_s", "rms_mm", "max_mm", "rms_3d_mm", "max_3d_mm",
    "motor_rms_rad",
}  # fmt: skip


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """Folder with what the demo wrote for one position and one speed."""
    folder = tmp_path_factory.mktemp("demo")
    pytest.importorskip("ffgym.report")
    arguments = ["--positions", "p1", "--speeds-mm-s", "100", "--report", "page.html", "--json", "numbers.json"]
    arguments = [str(folder / a) if a.endswith(("html", "json")) and "-" not in a else a for a in arguments]
    assert main(["demo", "--no-diagnosis", *arguments]) == 0
    return folder


def test_the_demo_writes_a_report_and_every_number(demo):
    assert {p.name for p in demo.iterdir()} == {"page.html", "numbers.json"}
    assert "<html" in (demo / "page.html").read_text(encoding="utf-8")


def test_the_numbers_have_rows_per_circle_and_law(demo, irb4600):
    numbers = json.loads((demo / "numbers.json").read_text())
    assert {"command", "robot", "seed", "versions", "physics_fingerprint", "rows", "one_axis"} <= numbers.keys()
    assert numbers["seed"] is None
    assert numbers["robot"] == irb4600.name
    assert numbers["versions"].keys() == {"ffgym", "mujoco", "numpy", "scipy", "gymnasium", "python"}
    assert numbers["physics_fingerprint"] == physics_fingerprint(compile_model(irb4600, ModelOptions(looks=False)))
    rows = numbers["rows"]
    cells = {(row["agent"], row["position"], row["radius_mm"], row["speed_mm_s"]) for row in rows}
    agents = ("none", "lugre_static", "lugre_dynamic")
    assert cells == {(agent, "p1", radius, 100.0) for agent in agents for radius in (1.0, 3.0, 5.0)}
    assert len(rows) == 9
    for row in rows:
        assert row.keys() == ROW_KEYS
        assert row["plant"] == "nominal"
        assert len(row["motor_rms_rad"]) == 6
        assert 0 < row["rms_mm"] <= row["max_mm"] <= row["max_3d_mm"]
        assert row["rms_mm"] <= row["rms_3d_mm"] <= row["max_3d_mm"]
    assert {(r["agent"], r["frequency_hz"]) for r in numbers["one_axis"]} == {
        (a, f) for a in agents for f in (1.0, 3.0)
    }


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--positions", "p9"], "Unknown position 'p9'. Available: p1, p2, p3, p4"),
        (["--robot", "one_axis"], "Robot 'one_axis' has no work area"),
        (["--speeds-mm-s", "0"], "speed = 0.0 m/s is out of range"),
        (["--speeds-mm-s", "90000"], ""),
        (["--report", ""], ".: is a folder, must be a file"),
        (["--report", "loop.html"], "loop.html: cannot be written: Too many levels of symbolic links"),
        (["--json", "loop.html"], "loop.html: cannot be written: Too many levels of symbolic links"),
    ],
)
def test_a_demo_that_cannot_run_is_one_line_and_exit_code_1(arguments, message, capsys, tmp_path, monkeypatch):
    pytest.importorskip("ffgym.report")
    monkeypatch.chdir(tmp_path)
    loop = tmp_path / "loop.html"
    loop.symlink_to(loop)
    assert main(["demo", "--report", "r.html", *arguments]) == 1
    assert message in read_error(capsys)
    assert list(tmp_path.iterdir()) == [loop]


def test_a_link_that_leads_to_itself_is_no_file_that_a_command_reads(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("loop.toml").symlink_to("loop.toml")
    assert main(["simulate", "one_axis", "loop.toml", "--json", "n.json"]) == 1
    assert "loop.toml: cannot be read: Too many levels of symbolic links" in read_error(capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["loop.toml"]


@pytest.mark.parametrize(
    ("command", "shown"),
    [
        (["emulate", "egm", "--longest-s", "nan"], "--longest-s = nan"),
        (["export", "program", "plan.npz", "--tolerance-mm", "inf"], "--tolerance-mm = inf"),
        (["demo", "--speeds-mm-s", "10", "nan"], "--speeds-mm-s = nan"),
        (["train", "bspline", "--gamma=-inf"], "--gamma = -inf"),
    ],
)
def test_numbers_of_options_are_finite(command, shown, capsys):
    assert main(command) == 1
    assert read_error(capsys) == f"ffgym: error: {shown} must be a finite number."


def test_work_that_the_memory_is_too_small_for_is_one_line(monkeypatch, capsys):
    def fill(config):
        raise MemoryError("Unable to allocate 15 GiB")

    monkeypatch.setattr("ffgym.cli.export.run", fill)
    assert main(["export", "one_axis"]) == 1
    message = "The memory of this computer is too small for it: Unable to allocate 15 GiB. Ask for less at once."
    assert read_error(capsys) == f"ffgym: error: {message}"


def test_a_missing_extra_is_named(monkeypatch, capsys):
    monkeypatch.setattr("ffgym.cli.outputs.is_installed", lambda name: name != "jinja2")
    assert main(["demo"]) == 1
    assert "needs jinja2; pip install 'ffgym[cli,report]'" in capsys.readouterr().err


def test_a_missing_tyro_is_named(monkeypatch, capsys):
    monkeypatch.setattr("ffgym.cli.main.is_installed", lambda name: name != "tyro")
    assert main(["export"]) == 1
    assert read_error(capsys) == "ffgym: error: The command line needs tyro; pip install 'ffgym[cli]'."


def test_an_interrupt_is_exit_code_130(monkeypatch, capsys):
    def interrupt(config):
        raise KeyboardInterrupt

    monkeypatch.setattr("ffgym.cli.export.run", interrupt)
    assert main(["export", "one_axis"]) == 130
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ffgym: interrupted")


def test_an_error_of_several_lines_becomes_one(monkeypatch, capsys):
    def fail(config):
        raise FFGymError("first\n  second\tthird")

    monkeypatch.setattr("ffgym.cli.export.run", fail)
    assert main(["export", "one_axis"]) == 1
    assert capsys.readouterr().err == "ffgym: error: first second third\n"


@pytest.mark.parametrize("arguments", [["dance"], [], ["demo", "--colour", "red"], ["demo", "--threads", "many"]])
def test_arguments_that_do_not_parse_are_exit_code_2(arguments, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert capsys.readouterr().err


def test_help_is_exit_code_0(capsys):
    with pytest.raises(SystemExit) as caught:
        main(["demo", "--help"])
    assert caught.value.code == 0
    out = capsys.readouterr().out
    assert "--speeds-mm-s" in out
    assert out.startswith("example: ffgym demo ")


@pytest.mark.parametrize("option", ["--help", "-h"])
def test_help_lists_every_command_with_an_example(option, capsys):
    assert main([option]) == 0
    out = capsys.readouterr().out
    assert all(f"  {name} " in out for name in COMMANDS)
    assert f"  ffgym demo {COMMANDS['demo'].example}\n" in out
    assert all(command.example for command in COMMANDS.values())


def test_version_is_the_package_s(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"ffgym {__version__}\n"


@pytest.mark.parametrize("old", sorted(_MOVED))
def test_an_old_name_answers_with_the_new_one(old, capsys):
    assert main([old]) == 1
    assert _MOVED[old] in read_error(capsys)


def test_a_process_returns_the_exit_code(tmp_path):
    def code(*arguments):
        done = subprocess.run(
            [sys.executable, "-W", "error", "-m", "ffgym", *arguments], capture_output=True, text=True, cwd=tmp_path
        )
        return done.returncode, done.stderr

    assert code("export", "one_axis", "--out", "arm") == (0, "")
    failed, message = code("export", "absent")
    assert failed == 1
    assert len(message.splitlines()) == 1
    assert code("dance")[0] == 2
    assert [p.name for p in tmp_path.iterdir()] == ["arm"]


def test_the_demo_on_a_workcell_says_so_and_names_the_seed_of_its_sensors(tmp_path, capsys):
    arguments = ["--positions", "p1", "--speeds-mm-s", "100", "--agents", "none", "--json", str(tmp_path / "n.json")]
    arguments += ["--report", str(tmp_path / "r.html"), "--no-diagnosis"]
    assert main(["demo", "--robot", "workcell:thesis", *arguments]) == 0
    assert "machine: thesis" in " ".join(capsys.readouterr().out.split())
    assert "machine: thesis" in (tmp_path / "r.html").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "n.json").read_text())["seed"] == 0


def test_the_demo_runs_every_position_and_speed_by_default():
    assert Demo().positions == ()
    assert Demo().speeds_mm_s == (10.0, 40.0, 100.0)
    assert replace(Demo(), robot="one_axis").robot == load_robot("one_axis").name
    assert __version__


@pytest.fixture
def one_finding(monkeypatch):
    """A diagnosis that finds something at once."""
    found = full_diagnosis()
    examined = Examination(diagnosis=found, before=None, after=None, machine=None, nominal=None)
    monkeypatch.setattr("ffgym.cli.demo.examine", lambda *arguments, **options: examined)
    return found


def test_the_demo_ends_with_a_diagnosis_on_a_page_in_print_and_in_the_numbers(one_finding, tmp_path, capsys):
    pytest.importorskip("ffgym.report")
    arguments = ["--positions", "p1", "--speeds-mm-s", "100", "--agents", "none", "--report", str(tmp_path / "r.html")]
    assert main(["demo", *arguments, "--json", str(tmp_path / "n.json")]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert f"{one_finding.verdict}: {one_finding.sentence}" in told
    assert f"diagnosis: {tmp_path / 'r_diagnosis.html'}" in told
    page = html.unescape((tmp_path / "r_diagnosis.html").read_text(encoding="utf-8"))
    assert one_finding.sentence in page
    numbers = json.loads((tmp_path / "n.json").read_text(encoding="utf-8"))
    origin = numbers["diagnosis"].pop("provenance")
    assert numbers["diagnosis"].items() <= json.loads(json.dumps(diagnosis_document(one_finding))).items()
    # both pages say which files were read, and have commands to go on with
    assert sum("ffgym/diagnosis/data/" in line for line in origin["inputs"]) == 8
    assert all(line in page for line in origin["inputs"])
    assert "ffgym diagnose --out found\nffgym record irb4600_60_205 found/next.toml --record-dt-ms 4" in page
    (robot,) = numbers["inputs"]
    assert re.fullmatch(r"ffgym/robot/data/irb4600_60_205.toml sha256:[0-9a-f]{64}", robot)
    demo_page = html.unescape((tmp_path / "r.html").read_text(encoding="utf-8"))
    assert robot in demo_page
    again = f"ffgym demo --agents none --report {tmp_path / 'r.html'}"
    assert f"<pre>{again} --json {tmp_path / 'n.json'} --positions p1 --speeds-mm-s 100.0\nffgym diagnose" in demo_page
    assert len(numbers["rows"]) == 3


def test_the_page_of_the_diagnosis_is_checked_before_anything_runs(tmp_path, capsys):
    pytest.importorskip("ffgym.report")
    (tmp_path / "r_diagnosis.html").mkdir()
    assert main(["demo", "--report", str(tmp_path / "r.html")]) == 1
    assert "r_diagnosis.html" in capsys.readouterr().err
    assert not (tmp_path / "r.html").exists()


@pytest.mark.slow
def test_the_whole_demo_names_both_faults_of_the_example_logs(tmp_path, capsys):
    pytest.importorskip("ffgym.report")
    arguments = ["--positions", "p1", "--speeds-mm-s", "100", "--report", str(tmp_path / "r.html")]
    assert main(["demo", *arguments, "--json", str(tmp_path / "n.json")]) == 0
    found = json.loads((tmp_path / "n.json").read_text(encoding="utf-8"))["diagnosis"]
    assert found["verdict"] in ("named", "partly")
    assert [(cause["effect"], cause["joint"]) for cause in found["causes"]][:2] == [
        ("load_friction", "j2"),
        ("torque_ripple", "j5"),
    ]


def test_report_and_numbers_need_two_files(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["demo", "--report", "a.html", "--json", str(tmp_path / "a.html")]) == 1
    assert "they need two files" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_the_demo_runs_the_agents_and_parameters_it_is_given(tmp_path, irb4600):
    pytest.importorskip("ffgym.report")
    values = irb4600.friction.coulomb.tolist()
    wrong = tmp_path / "wrong.toml"
    table = "[friction.{}]\nvalue = {}\nunit = 'N m'\nside = 'motor'\norigin = 'chosen'\nsource = 'test'\n"
    halves = [v / 2 for v in values]
    wrong.write_text(table.format("coulomb", halves) + table.format("static", halves), encoding="utf-8")
    shared = ["demo", "--positions", "p1", "--speeds-mm-s", "100", "--report", str(tmp_path / "r.html")]
    shared.append("--no-diagnosis")
    rows = {}
    for name, more in {"own": [], "wrong": ["--parameters", str(wrong)]}.items():
        arguments = [*shared, "--agents", "none", "lugre_static", "--json", str(tmp_path / f"{name}.json"), *more]
        assert main(arguments) == 0
        rows[name] = json.loads((tmp_path / f"{name}.json").read_text())["rows"]
    assert {row["agent"] for row in rows["own"]} == {"none", "lugre_static"}
    for own, other in zip(rows["own"], rows["wrong"], strict=True):
        assert (own == other) is (own["agent"] == "none")  # the machine is the same, the agent's model is not


@pytest.mark.parametrize("wrong", ["nobody", "absent.npz", "lugre_static"])
def test_wrong_agents_are_refused_before_any_is_made(wrong, capsys, monkeypatch):
    pytest.importorskip("ffgym.report")
    monkeypatch.setattr("ffgym.cli.laws.make_law", lambda name, setting: pytest.fail(f"made {name}"))
    assert main(["demo", "--agents", "lugre_static", wrong]) == 1
    assert wrong in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--agents"], "There is no agent to run"),
        (["--agents", "nobody"], "Unknown agent 'nobody'. Available: "),
        (["--agents", "none", "none"], "must have different names"),
        (["--agents", "absent.npz"], "absent.npz: no such file"),
        (["--parameters", "absent.toml"], "Cannot read parameter file absent.toml"),
    ],
)
def test_agents_and_parameters_that_are_not_there_are_one_line(arguments, message, capsys, tmp_path, monkeypatch):
    pytest.importorskip("ffgym.report")
    monkeypatch.chdir(tmp_path)
    assert main(["demo", "--positions", "p1", "--speeds-mm-s", "100", *arguments]) == 1
    assert message in read_error(capsys)


def test_every_subcommand_has_options_and_a_function_that_takes_them():
    for command in COMMANDS.values():
        options, work = load_object(command.options), load_object(command.work)
        assert work.__annotations__ == {"config": options, "return": None}


def test_help_of_every_command_loads_next_to_nothing_of_the_package_and_no_library_that_computes():
    script = (
        "import sys; from ffgym.cli.main import COMMANDS, main\n"
        "for name in COMMANDS:\n"
        "    try: main([*name.split(), '--help'])\n"
        "    except SystemExit: pass\n"
        "print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded_modules = done.stdout.splitlines()[-1].split()
    computing = {"mujoco", "scipy", "torch", "stable_baselines3", "matplotlib", "jinja2", "rich", "imageio", "lark"}
    assert not computing & set(loaded_modules)
    assert len([name for name in loaded_modules if name.startswith("ffgym")]) <= 30


def test_modules_of_commands_load_no_library_that_only_some_of_their_options_need():
    script = (
        "import sys; from ffgym.cli.main import COMMANDS, load_object\n"
        "for command in COMMANDS.values(): load_object(command.work)\n"
        "print([name for name in ('torch', 'stable_baselines3', 'matplotlib', 'jinja2', 'rich', 'imageio', 'ray') "
        "if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_defaults_of_options_that_the_library_has_too_are_the_same():
    assert Export(robot="r").record_dt_ms == RECORD_DT * 1e3
    assert Diagnose().most_causes == settings().search.most_causes
    identify = Identify(logs=(), robot="r")
    assert (identify.level, identify.resamples) == (LEVEL, RESAMPLES)
    assert Leaderboard().plants == (NOMINAL, THESIS_WORKCELL)
    assert Leaderboard().splits == THESIS

"""An example of each command that writes, small enough to be killed and begun again many times."""

import re
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import get_type_hints

import numpy as np

from ffgym.agents.residual.policy import encode_policy
from ffgym.cli.main import COMMANDS, load_object, main
from ffgym.leaderboard.submission import judge
from tests.agents.residual.residual_samples import policy_of
from tests.leaderboard.submission_samples import PLAN, agent_file
from tests.robot.template.arm_xml import ARM, NUMBERS

READ = {
    *("parameters", "logs", "log", "validate", "arm", "plan", "controller", "trial", "pilot"),
    *("adaptation", "submission", "round", "committed"),
}
"""Options that name files which are read. Any other one with a path is taken to be written."""


@dataclass(frozen=True)
class Example:
    """A command with arguments: files that it makes are in the working directory, those that it reads in ../stock."""

    arguments: str
    makes: str = ""
    """Folder that it makes, whole or not at all, and does not write over."""
    given: tuple[str, ...] = ()
    """Files of the stock that are put into the working directory, as the command changes them."""
    differs: Callable[[bytes], bytes] = lambda data: data
    """Function that takes out of a file what may differ between runs, beside the minute in which a page was made."""
    is_slow: bool = False
    """True if it takes longer than a second or two."""
    needs: tuple[str, ...] = ()
    """Packages and programs beside those of all commands."""


def _without(*names):
    """Take numbers of these names out of JSON, which are measured times."""
    pattern = re.compile(rb'("(?:' + "|".join(names).encode() + rb')": )[-+.e\w]+')
    return lambda data: pattern.sub(rb"\1null", data)


REAL_TIME = {"stream"}
"""Commands that write what a controller sends in real time, which is other bytes each time."""


def make_stock():
    """Make the files that examples read, in the working directory."""
    texts = {"arm.xml": ARM, "sine.toml": SINE, "session.toml": SESSION, "move.toml": MOVE, "map.toml": MAP}
    for name, text in texts.items():
        Path(name).write_text(text, encoding="utf-8")
    rows = "".join(f"{0.004 * k},{np.sin(0.004 * k)}\n" for k in range(50))
    Path("trace.csv").write_text(f"time,axis1\n{rows}", encoding="utf-8")
    _run("robot new arm.xml --out cutter.toml")
    with Path("cutter.toml").open("a", encoding="utf-8") as file:
        file.write("".join(NUMBERS.values()))
    for command in (
        "plan irb4600_60_205 move.toml --feedforward none --out move.npz",
        "plan one_axis sine.toml --feedforward lugre_static --out plan.npz",
        "record one_axis session.toml --record-dt-ms 4 --out logs",
        "trial plan one_axis sine.toml --runs 4 --seed 3 --out trial",
    ):
        _run(command)


def make_whole_stock():
    """Make the files that slow examples read, too, and let submissions run one circle."""
    make_stock()
    _run("trial rehearse trial --machine one_axis --feedforward lugre_static --out rehearsal")
    _run("plan one_axis --seconds 1 --out probe.npz")
    _run("emulate egm --robot one_axis --plan probe.npz --log stream.npz")
    judge.STANDARD = PLAN
    Path("mine.py").write_bytes(agent_file())
    _run("leaderboard submit mine.py --name mine --author me --track causal --out agent.zip")
    Path("policy.npz").write_bytes(encode_policy(policy_of()))
    Path("six.toml").write_text(SESSION, encoding="utf-8")


def _run(command):
    assert main(command.split()) == 0, command


def writing_commands():
    """List the commands that have an option with a path that is written, found by the types of their options."""
    return [name for name in COMMANDS if _written(load_object(COMMANDS[name].options)) or name == "robot fill"]


def _written(options):
    hints = get_type_hints(options)
    return [field.name for field in fields(options) if _is_path(hints[field.name]) and field.name not in READ]


def _is_path(hint):
    return "Path" in str(hint)


SINE = """
[[part]]
kind = "sine"
frequency = 2.0
amplitude = 0.002
duration = 0.5
"""
MOVE = """
start = [0.0, 0.35, 0.17, 0.0, 0.54, 0.0]

[[part]]
kind = "joints"
to_deg = [0.5, 20.0, 10.0, 0.0, 31.0, 0.0]
speed = 0.05
"""
SESSION = """
[[step]]
protocol = "excitation"
count = 2
base = 0.5
periods = 1
"""
MAP = """
[log]
robot = "one_axis"
position_side = "link"
torque_semantics = "motor_side"
hold = "sampled"
[columns]
timestamp = { source = "time", unit = "s" }
"motor.position" = { source = "axis1", unit = "rad" }
"""
TABLE = 'title = "mine"\nrobot = "irb4600_60_205"\nrows = "rows.csv"\n'
ROWS = """use,position,speed_mm_s,radius_mm,law,statistic,value_mm
fitted,p1,100,3,none,rms,0.20
fitted,p2,100,3,none,rms,0.25
held_out,p3,100,3,none,rms,0.25
"""

EXAMPLES = {
    "demo": Example("--no-diagnosis --positions p1 --speeds-mm-s 100 --agents none --json n.json", is_slow=True),
    "robot new": Example("../stock/arm.xml --out new.toml --force"),
    "robot fill": Example("cutter.toml", given=("arm.xml", "cutter.toml")),
    "robot check": Example("one_axis --report r.html --json n.json"),
    "simulate": Example(
        "one_axis ../stock/sine.toml --feedforward none lugre_static --out r.npz --report r.html --json n.json"
    ),
    "play": Example("--env ffgym/OneAxis-v1 --out e.gif --fps 2 --playback 1 --width 64 --height 64 --json n.json"),
    "export": Example("one_axis ../stock/sine.toml --out model --json n.json", makes="model"),
    "export code": Example(
        "one_axis ../stock/sine.toml --feedforward lugre_static --unchecked --out law --json n.json", makes="law"
    ),
    "export table": Example(
        "one_axis ../stock/sine.toml --feedforward lugre_static --out table --json n.json", makes="table"
    ),
    "export fmu": Example(
        "one_axis ../stock/sine.toml --feedforward lugre_static --fmi 2.0 --out fmu --json n.json",
        makes="fmu",
        is_slow=True,
        needs=("fmpy", "cc"),
    ),
    "export program": Example("../stock/move.npz --format csv --out program --json n.json", makes="program"),
    "export policy": Example("../stock/policy.npz --out p.onnx --json n.json", is_slow=True, needs=("onnxruntime",)),
    "record": Example(
        "one_axis ../stock/session.toml --record-dt-ms 4 --out logs --json n.json", differs=_without("made", "kept")
    ),
    "log columns": Example("../stock/trace.csv --out draft.toml --force --json n.json"),
    "log convert": Example("../stock/trace.csv --columns ../stock/map.toml --out r.npz --json n.json"),
    "log check": Example("../stock/logs --robot one_axis --report r.html --json n.json"),
    "identify": Example(
        "../stock/logs --robot one_axis --what rigid_body --resamples 2 --unchecked --out p.toml --report r.html "
        "--json n.json"
    ),
    "identify controller": Example("../stock/stream.npz --robot one_axis --out c.toml --json n.json", is_slow=True),
    "diagnose": Example("../stock/logs --robot one_axis --most-causes 1 --out found --json n.json", is_slow=True),
    "plan": Example("one_axis ../stock/sine.toml --feedforward lugre_static --out plan.npz --json n.json"),
    "emulate": Example("egm --robot one_axis --plan ../stock/plan.npz --log l.npz --out t.npz --json n.json"),
    "trial plan": Example("one_axis ../stock/sine.toml --runs 4 --seed 3 --out trial --json n.json", makes="trial"),
    "trial rehearse": Example(
        "../stock/trial --machine one_axis --feedforward lugre_static --out logs --json n.json", makes="logs"
    ),
    "trial read": Example("../stock/trial ../stock/rehearsal --report r.html --json n.json", is_slow=True),
    "train policy": Example(
        "--base lugre_dynamic --steps 48 --out mine --json n.json "
        "--set n_envs=2 n_steps=8 batch_size=8 segment_steps=16 n_epochs=2",
        is_slow=True,
        needs=("torch",),
    ),
    "train bspline": Example("--robot one_axis --frequencies-hz 4 --iterations 2 --resume --out law.npz --json n.json"),
    "train stability": Example("--robot one_axis --frequencies-hz 4 --iterations 1 --figure f.svg --figure-rates 0.4"),
    "leaderboard": Example(
        "--agents none --plants nominal --splits speeds --jobs 1 --out rows --page p.html --json n.json",
        differs=_without("wall_s", "bare_s", "simulated_s", "inference_us"),
        is_slow=True,
    ),
    "leaderboard submit": Example(
        "../stock/mine.py --name mine --author me --track causal --out agent.zip --json n.json",
        differs=_without("inference_us_measured"),
        is_slow=True,
    ),
    "leaderboard verify": Example(
        "../stock/agent.zip --machines 0 --json n.json", differs=_without("inference_us"), is_slow=True
    ),
    "leaderboard round": Example("", differs=lambda data: re.sub(rb"[0-9a-f]{12,}", b"drawn", data)),
    "improve": Example(
        "--rig irb4600_60_205 --out better --rounds 1 --most-causes 1 --protocols ../stock/six.toml "
        "--positions p2 --speeds-mm-s 100 --radii-mm 1",
        is_slow=True,
    ),
}

"""Agents, honest and not, and submissions of them that are small enough to be checked often."""

import json

from ffgym.agents.submission import LOADERS
from ffgym.leaderboard.submission.judge import Judge
from ffgym.leaderboard.submission.manifest import (
    MANIFEST,
    About,
    AgentSource,
    decode_archive,
    digest_of,
    encode_archive,
)
from ffgym.leaderboard.submission.process import AgentProcess, Limits
from ffgym.leaderboard.tasks import Task

ROBOT = "irb4600_60_205"
PLAN = {"nominal": (Task("p2", 0.1, (0.001,), "positions"),)}
SIDE_BY_SIDE = {"nominal": tuple(Task("p2", 0.1, (radius,), "positions") for radius in (0.001, 0.003))}
"""Two motions, on which agents decide at once."""
ABOUT = About(name="mine", title="an agent of mine", author="somebody", track="causal, nominal parameters")
PYTHON = AgentSource(kind="python", file="agent.py")
FILE = """
import time

import numpy as np

PREVIEW, ACTION_SCALE = 1, 10.0
{head}

class Mine:
    def __init__(self, layout):
        self.layout = layout

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        count = 0 if state is None else state
        action = 0.01 * self.layout.read(observation, "reference_velocity", ahead_by=1) / 100.0
        {body}
        return action, count + 1


def make_agent(robot, layout):
    return Mine(layout)
"""
"""An agent that pushes with the speed, with something at its head and something in its `predict`."""


def agent_file(body="pass", head=""):
    """Bytes of an agent's file."""
    lines = body.replace("\n", "\n        ")
    return FILE.format(head=head, body=lines).encode()


def packed(source=PYTHON, content=None, plan=PLAN):
    """Submission of an agent, an honest one if there is no content."""
    content = agent_file() if content is None and source.kind == "python" else content
    return judge(plan).pack(ABOUT, source, content)


def judge(plan=PLAN, **limits):
    """What packs and checks these submissions."""
    return Judge(loaders=LOADERS, plan=plan, limits=Limits(**limits), n_threads=1)


def process(content, **limits):
    """An agent's file in a process."""
    return AgentProcess(PYTHON, content, ROBOT, loaders=LOADERS, seed=0, limits=Limits(**limits))


def changed(data, files=(), manifest=(), *, signed=True):
    """A submission with other files (None takes one away) and other entries in its manifest, signed or not."""
    own = decode_archive(data)
    tree = json.loads(own[MANIFEST]) | dict(manifest)
    if signed:
        tree["digest"] = digest_of(tree)
    own[MANIFEST] = json.dumps(tree).encode()
    return encode_archive({name: each for name, each in (own | dict(files)).items() if each is not None})


def manifest_of(data):
    """Manifest of a submission as JSON."""
    return json.loads(decode_archive(data)[MANIFEST])

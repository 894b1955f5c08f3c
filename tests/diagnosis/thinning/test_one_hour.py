"""One hour of six axes at 1 kHz is diagnosed in less than 3 GB."""

import json
import os
import subprocess
import sys
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from ffgym.effects import EFFECTS
from ffgym.recordings.npz import HEADER_KEY
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import plan_session, usual_sensors
from ffgym.simulation.protocols.mixtures import DiagnosisMotions

HOUR, DT = 3600.0, 0.001

FAMILIES = ("motor.position", "motor.velocity", "motor.effort", "reference.position", "tcp.position", "temperature")

PROCESS = """
import sys
from ffgym.cli import main
sys.argv = ["ffgym", "diagnose", *sys.argv[1:]]
try:
    main()
finally:
    print("peak", open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
"""
"""The command, and the most memory that it had [kB]: `resource` would count that of the process that starts it."""


def motions(arm):
    """Motions of the protocol that begin and end in one posture."""
    references = [motion.reference for motion in plan_session(arm, [DiagnosisMotions(pause=1.0)])]
    home = references[0].q[0]
    return [one for one in references if np.allclose(one.q[[0, -1]], home, atol=1e-6)]


def write_hour(arm, machine, path):
    """Write one recording of an hour that repeats some motions with new noise, one column after the other."""
    robot, rng = arm.robot, np.random.default_rng(4)
    runs = [Run(reference=reference) for reference in motions(arm)]
    made = simulate(runs, machine=machine, sensors=usual_sensors(robot), record_dt=DT, n_threads=1)
    noise = 0.03 * robot.friction.coulomb
    rows = round(HOUR / DT)
    times = -(-rows // sum(map(len, made)))
    order = [k for _ in range(times) for k in rng.permutation(len(made))]
    columns = [name for name in made[0].columns if name.startswith(FAMILIES)]
    header = replace(made[0].header, segment="hour", phases=(), meta={})
    with zipfile.ZipFile(path, "w") as file:

        def write(name, values):
            with file.open(f"{name}.npy", "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, values)

        write(HEADER_KEY, np.array(header.to_json()))
        write("timestamp", DT * np.arange(rows))
        for name in columns:
            values = np.concatenate([made[k][name] for k in order])[:rows]
            if name.startswith("motor.effort."):
                values += rng.normal(scale=noise[robot.joints.index(name.rpartition(".")[2])], size=rows)
            write(name, values)


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="memory is known from /proc")
def test_an_hour_of_six_axes_at_1_khz_is_diagnosed_in_less_than_3_gb(irb4600, arm, tmp_path):
    machine = Machine(robot=irb4600, effects=(EFFECTS["viscous_level"].on(irb4600, "j2", change=0.3),))
    write_hour(arm, machine, tmp_path / "hour.npz")
    command = [sys.executable, "-c", PROCESS, str(tmp_path / "hour.npz"), "--robot", irb4600.name]
    done = subprocess.run(
        [*command, "--json", str(tmp_path / "found.json")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    peak = float(done.stdout.split("peak ")[1])
    assert peak < 3e6
    found = json.loads((tmp_path / "found.json").read_text())
    causes = [(cause["effect"], cause["joint"]) for cause in found["causes"]]
    assert causes == [("viscous_level", "j2")]
    assert any("of 3600 s are used" in note for note in found["quality"])

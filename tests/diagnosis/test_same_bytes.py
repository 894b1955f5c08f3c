"""The same logs give the same diagnosis, to the byte; what is remembered of logs before changes hardly anything."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits  # type: ignore[import-untyped]

from ffgym.diagnosis import DiagnosisCache, diagnose, examine, procedure
from ffgym.diagnosis.computing import on_one_thread
from ffgym.diagnosis.diagnosis_file import diagnosis_document
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.recordings.io import write_recording
from ffgym.robot import load_robot
from ffgym.simulation import Resolver, Run, TorqueSensor, simulate
from ffgym.simulation.plant import Machine


def logs(robot, *effects, seed):
    """Two short motions of one axis, with noise."""
    paths = [
        multisine([0.0], np.full((2, 1), 8.0), [0.4, 1.1], np.full((2, 1), phase), 4.0, name=f"sines {phase}")
        for phase in (0.0, 1.5)
    ]
    sensors = (Resolver(bits=16), TorqueSensor(noise=np.array([0.01])))
    runs = [Run(reference=joint_reference(robot, path)) for path in paths]
    machine = Machine(robot=robot, effects=effects)
    return simulate(runs, machine=machine, sensors=sensors, seed=seed, record_dt=0.004, n_threads=1)


def as_text(diagnosis):
    return json.dumps(diagnosis_document(diagnosis), sort_keys=True)


@pytest.fixture(scope="module")
def faulty(one_axis):
    return logs(one_axis, EFFECTS["coulomb_level"].on(one_axis, change=0.25), seed=1)


@pytest.fixture(scope="module")
def alone(one_axis, faulty):
    return diagnose(one_axis, faulty)


def test_the_same_logs_give_the_same_bytes(one_axis, faulty, alone):
    assert as_text(diagnose(one_axis, faulty)) == as_text(alone)
    assert as_text(diagnose(one_axis, faulty, cache=DiagnosisCache())) == as_text(alone)


def test_what_is_remembered_of_another_log_changes_no_cause_and_its_size_by_less_than_its_interval(
    one_axis, faulty, alone
):
    """Both logs have their own noise, to which the band of standing motors is made, but one is that of the memory."""
    memory = DiagnosisCache()
    diagnose(one_axis, logs(one_axis, seed=2), cache=memory)
    helped = diagnose(one_axis, faulty, cache=memory)
    assert (helped.verdict, [c.effect for c in helped.causes]) == (alone.verdict, [c.effect for c in alone.causes])
    (one,), (other,) = helped.causes[0].parameters, alone.causes[0].parameters
    assert one.value == pytest.approx(other.value, abs=0.05 * (other.interval[1] - other.interval[0]))
    assert other.interval[0] < 0.25 < other.interval[1]


def test_nothing_is_remembered_of_the_same_motions_in_another_band(one_axis, faulty, monkeypatch):
    """A log in which something is faster than its filter is compared in a narrower band, with fewer rows."""
    memory = DiagnosisCache()
    diagnose(one_axis, faulty, cache=memory)
    monkeypatch.setattr(procedure, "choose_cutoff", lambda log, machine: 0.3 * log.sampling.cutoff)
    assert as_text(diagnose(one_axis, faulty, cache=memory)) == as_text(diagnose(one_axis, faulty))


def test_the_order_in_which_logs_are_given_changes_no_byte_but_that_of_their_names(one_axis, faulty, alone):
    turned = diagnose(one_axis, faulty[::-1])
    assert turned.motions == alone.motions[::-1]
    assert as_text(replace(turned, motions=alone.motions)) == as_text(alone)


def test_linear_algebra_of_a_diagnosis_is_on_one_thread():
    def threads():
        return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}

    with threadpool_limits(limits=2):
        before = threads()
        assert 2 in before
        assert on_one_thread(threads)() == {1}
        assert threads() == before
    assert hasattr(examine, "__wrapped__")


PROCESS = """
import json, sys
from ffgym.diagnosis import diagnose
from ffgym.recordings.io import read_folder
from ffgym.robot import load_robot
from tests.diagnosis.test_same_bytes import as_text
print(as_text(diagnose(load_robot("two_link"), read_folder(sys.argv[1]))))
"""


def test_threads_and_processes_change_no_byte(tmp_path):
    """Two joints with an elastic arm: sums over so many columns that libraries would split them among threads."""
    robot = load_robot("two_link")
    machine = Machine(robot=robot, effects=(EFFECTS["coulomb_level"].on(robot, change=0.25),))
    amplitude = np.array([[0.3, 0.3], [0.1, 0.1]])
    references = [
        joint_reference(
            robot, multisine([0.3, 0.5], amplitude, [0.3, 1.1], np.full((2, 2), phase), 4.0, name=f"{phase}")
        )
        for phase in (0.0, 1.5)
    ]
    sensors = (Resolver(bits=16), TorqueSensor(noise=np.full(2, 0.02)))
    runs = [Run(reference=reference) for reference in references]
    for one in simulate(runs, machine=machine, sensors=sensors, seed=1, record_dt=0.004, n_threads=1):
        write_recording(one, tmp_path / f"{one.header.segment}.npz")
    found = set()
    for threads in ("1", "2", "4"):
        environment = os.environ | {"OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads}
        command = [sys.executable, "-c", PROCESS, str(tmp_path)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        found.add(done.stdout)
    assert len(found) == 1

"""Which frequencies are tried: what peaks, what turns with a shaft, each once."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.patterns.periodic import Spectrum
from ffgym.diagnosis.search import generator as module
from ffgym.diagnosis.search.generator import CandidateGenerator, _exclude_tried, _find_peaks


def test_a_frequency_is_tried_once_however_often_it_was_found():
    found = {"j1": [12.0, 12.1, 1.0, 2.0, 1.1], "j2": [6.0], "j3": []}
    assert _exclude_tried(found, {"j2": (5.9,)}) == {"j1": (12.0, 1.0, 2.0)}
    assert _exclude_tried(found, {"j1": (12.0, 1.0, 2.0), "j2": (5.7,)}) == {"j2": (6.0,)}


def test_a_peak_beside_what_turns_with_the_shaft_does_not_stand_for_it():
    """The torque of a resolver's second wave peaked at 1.84 cycles per turn, which explained a tenth of it."""
    assert _exclude_tried({"j1": [0.994, 1.839, 1.0, 2.0]}, {}) == {"j1": (0.994, 1.839, 2.0)}
    assert _exclude_tried({"j1": [1.84, 2.0]}, {"j1": (0.994, 1.839, 2.0)}) == {}
    assert _exclude_tried({"j1": [2.0]}, {"j1": (1.839,)}) == {"j1": (2.0,)}


@pytest.mark.parametrize(
    ("loud", "energy", "sensors", "tried"),
    [
        (("torque", 0), 50.0, 1.0, True),
        (("torque", 0), 0.5, 1.0, False),
        (("torque", 0), 0.5, 0.01, True),  # of quiet sensors
        (("torque", 1), 50.0, 1.0, False),
        (("tool", 2), 50.0, 1.0, False),
    ],
)
def test_what_turns_with_the_shaft_is_tried_where_the_torque_of_its_joint_is_loud(
    monkeypatch, loud, energy, sensors, tried
):
    """Though nothing peaks there: the torque of an angle that is wrong turns its phase at each resonance."""
    robot = SimpleNamespace(joints=("j1", "j2"))
    monkeypatch.setattr(module, "assemble_residual", lambda *given: SimpleNamespace(robot=robot))
    monkeypatch.setattr(module, "components", lambda channel, robot: "xyz")
    flat = Spectrum(frequency=np.array([30.0, 40.0]), share=np.array([0.2, 0.1]))
    monkeypatch.setattr(module, "compute_turn_spectrum", lambda *given, **kind: flat)
    faultless = SimpleNamespace(sensor_share=lambda component, floor: sensors)
    ready = SimpleNamespace(problem=SimpleNamespace(log=None), floor=None, null=faultless)
    cycles = CandidateGenerator(ready, (), None)._cycles(SimpleNamespace(run=None), {}, {loud: energy})
    assert (1.0 in cycles["j1"] and 2.0 in cycles["j1"]) == tried
    assert (30.0 in cycles["j1"]) == (tried or loud == ("tool", 2))
    assert not cycles["j1"] or cycles["j1"][0] == 30.0  # the strongest first


def test_other_springs_are_tried_once_on_elastic_joints_whose_torque_is_far_off(monkeypatch):
    energies = {("torque", 0): 50.0, ("torque", 1): 50.0, ("torque", 2): 2.0, ("tool", 2): 50.0}
    run = SimpleNamespace(springs=SimpleNamespace(elastic=np.array([1, 2])))
    made = SimpleNamespace(beside=lambda columns: made)
    tried = []
    monkeypatch.setattr(module, "subtract_nuisances", lambda setting, fit: {})
    monkeypatch.setattr(module, "loudness", lambda setting, rest: energies)
    monkeypatch.setattr(module, "list_candidates", lambda *given: made)
    monkeypatch.setattr(module, "compute_stiffness_sensitivities", lambda run, joints: tried.append(joints))
    monkeypatch.setattr(CandidateGenerator, "_cycles", lambda *given: {})
    choice = CandidateGenerator(SimpleNamespace(problem=None, run=run), (module.JointStiffness,), None)
    choice(None)
    choice(None)
    energies["torque", 2] = 50.0
    choice(None)
    assert tried == [[1], [2]]
    assert CandidateGenerator(SimpleNamespace(problem=None, run=run), (), None)(None) is made
    assert len(tried) == 2


def test_peaks_are_the_highest_and_what_lies_beside_one_is_part_of_it():
    frequency = np.array([1.0, 1.1, 4.0, 6.0, 6.05])
    spectrum = Spectrum(frequency=frequency, share=np.array([0.5, 0.45, 0.1, 0.3, 0.29]))
    assert _find_peaks(spectrum, 3) == [(0.5, 1.0), (0.3, 6.0), (0.1, 4.0)]
    assert _find_peaks(spectrum, 1) == [(0.5, 1.0)]
    assert _find_peaks(None, 2) == []

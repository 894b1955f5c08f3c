"""Which frequencies are tried: what peaks, what turns with a shaft, each once."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.patterns.periodic import Spectrum
from ffgym.diagnosis.search import generator as module
from ffgym.diagnosis.search.generator import CandidateGenerator, _exclude_tried, _find_peaks
from ffgym.diagnosis.settings import settings


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


@pytest.mark.parametrize(("torque", "tried"), [(0.0, []), (0.999, []), (1.0, []), (1.001, [[1]])])
def test_a_torque_is_far_off_beyond_the_limit_alone(monkeypatch, torque, tried):
    """A joint without a torque in the log is not."""
    limit, found = settings().screening.spring_from, []
    energies = {("torque", 1): torque * limit} if torque else {}
    run = SimpleNamespace(springs=SimpleNamespace(elastic=np.array([1, 2])))
    made = SimpleNamespace(beside=lambda columns: made)
    monkeypatch.setattr(module, "subtract_nuisances", lambda setting, fit: {})
    monkeypatch.setattr(module, "loudness", lambda setting, rest: energies)
    monkeypatch.setattr(module, "list_candidates", lambda *given: made)
    monkeypatch.setattr(module, "compute_share_sensitivities", lambda run, joints: found.append(joints))
    monkeypatch.setattr(CandidateGenerator, "_cycles", lambda *given: {})
    CandidateGenerator(SimpleNamespace(problem=None, run=run), (module.ArmFriction,), None)(None)
    assert found == tried


def cycles_of(monkeypatch, spectra, energies, n_joints=1):
    """Frequencies found where components have such energies, with peaks by channel, component and amplitude."""

    def compute_turn_spectrum(residual, channel, component, joint, *, amplitude="constant"):
        share = np.zeros(100)
        for at, height in spectra.get((channel, component, amplitude), {}).items():
            share[at] = height
        return Spectrum(frequency=np.arange(100.0), share=share)

    robot = SimpleNamespace(joints=[f"j{j + 1}" for j in range(n_joints)])
    monkeypatch.setattr(module, "assemble_residual", lambda *given: SimpleNamespace(robot=robot))
    monkeypatch.setattr(module, "components", lambda channel, robot: "xyz" if channel == "tool" else robot.joints)
    monkeypatch.setattr(module, "compute_turn_spectrum", compute_turn_spectrum)
    faultless = SimpleNamespace(sensor_share=lambda component, floor: 1.0)
    ready = SimpleNamespace(problem=SimpleNamespace(log=None), floor=None, null=faultless)
    return CandidateGenerator(ready, (), None)._cycles(SimpleNamespace(run=None), {}, energies)


def test_two_peaks_of_one_amplitude_and_one_in_proportion_to_the_torque_are_tried(monkeypatch):
    spectra = {
        ("torque", "j1", "constant"): {30: 0.5, 40: 0.4, 50: 0.3},
        ("torque", "j1", "torque"): {60: 0.45, 70: 0.35},
    }
    assert cycles_of(monkeypatch, spectra, {("torque", 0): 1e3}) == {"j1": [30.0, 60.0, 40.0, 2.0, 1.0]}


def test_of_all_that_is_loud_behind_the_gearbox_the_highest_peak_is_tried(monkeypatch):
    """Link encoders of other joints say nothing of this one's gear; the tool is moved by all."""
    spectra = {
        ("tool", "x", "constant"): {10: 0.2, 11: 0.19},
        ("tool", "z", "constant"): {20: 0.3, 21: 0.29},
        ("link", "j1", "constant"): {30: 0.25},
        ("link", "j2", "constant"): {40: 0.9},
    }
    loud = {("tool", 0): 1e3, ("tool", 2): 1e3, ("link", 0): 1e3, ("link", 1): 1e3}
    assert cycles_of(monkeypatch, spectra, loud, n_joints=2) == {"j1": [20.0], "j2": [40.0]}


@pytest.mark.parametrize(("times", "found"), [(1.0, []), (1.001, [30.0])])
def test_a_component_is_loud_beyond_what_sensors_leave_alone(monkeypatch, times, found):
    energy = times * settings().screening.periodic_from
    assert cycles_of(monkeypatch, {("tool", "x", "constant"): {30: 0.5}}, {("tool", 0): energy}) == {"j1": found}


def test_frequencies_just_far_enough_apart_are_two():
    frequency, share = np.array([0.0, module._APART]), np.array([0.5, 0.4])
    assert _find_peaks(Spectrum(frequency=frequency, share=share), 2) == [(0.5, 0.0), (0.4, module._APART)]
    assert _exclude_tried({"j1": [module._APART]}, {"j1": (0.0,)}) == {"j1": (module._APART,)}


def test_peaks_are_the_highest_and_what_lies_beside_one_is_part_of_it():
    frequency = np.array([1.0, 1.1, 4.0, 6.0, 6.05])
    spectrum = Spectrum(frequency=frequency, share=np.array([0.5, 0.45, 0.1, 0.3, 0.29]))
    assert _find_peaks(spectrum, 3) == [(0.5, 1.0), (0.3, 6.0), (0.1, 4.0)]
    assert _find_peaks(spectrum, 1) == [(0.5, 1.0)]
    assert _find_peaks(None, 2) == []

"""Generator of candidates: all effects of the library, periodic ones at the frequencies that the residual has.

Where a joint is far from its description, much stiffer and softer springs are candidates, too, and much friction
behind them.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.fit.fit import Fit, Loudness, loudness, subtract_nuisances
from ffgym.diagnosis.patterns.periodic import Amplitude, Spectrum, compute_turn_spectrum
from ffgym.diagnosis.prepare import DiagnosisCache, PreparedSearch, list_candidates, repeats
from ffgym.diagnosis.residual import Channel, components
from ffgym.diagnosis.residual_rows import assemble_residual
from ffgym.diagnosis.search.candidates import Candidates
from ffgym.diagnosis.sensitivity import (
    compute_sensitivities,
    compute_share_sensitivities,
    compute_stiffness_sensitivities,
)
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.variant import Cycles
from ffgym.effects import Effect
from ffgym.effects.transmission.arm_friction import ArmFriction
from ffgym.effects.transmission.stiffness import JointStiffness

_LOOKED_FOR: tuple[tuple[Amplitude, int], ...] = (("constant", 2), ("torque", 1))
"""Peaks of a joint's torque that are tried as the frequency of a periodic effect, of what has one amplitude and of what
goes with the torque; behind the gearbox, where a gear that errs moves tool and encoder, it is the highest one."""

_SHAFT = (1.0, 2.0)
"""Cycles per turn that are tried beside them on joints whose torque is loud: a shaft that runs out, and an oval or
windings that differ. An angle that is wrong makes torques that grow with the square of the speed and turn their phase
at each resonance; they may be loud without a peak."""

_APART, _SHAFT_APART = 0.2, 0.02
"""Cycles per turn by which two such peaks differ at least, and a shaft's frequency from any: the peak of a torque that
changes with the speed lies beside it, by up to 0.16 in a log of small turns."""


class CandidateGenerator:
    """Generator of candidates beside the causes of a fit; candidates of one fit are kept for the next."""

    def __init__(self, ready: PreparedSearch, kinds: Sequence[type[Effect]], cache: DiagnosisCache | None) -> None:
        self._ready, self._kinds, self._cache = ready, kinds, cache
        self._tried: dict[str, tuple[float, ...]] = {}
        self._sprung: set[int] = set()
        self._made: Candidates | None = None

    def __call__(self, fit: Fit) -> Candidates:
        """Return candidates beside the causes of a fit: those from before, new frequencies, and other springs."""
        made = self._made or list_candidates(self._ready, self._kinds, self._cache)
        problem = self._ready.problem
        rest = subtract_nuisances(problem, fit)
        loud = loudness(problem, rest)
        # other springs, and friction behind them, on elastic joints whose torque is far from what it should be
        elastic = [j for j in self._ready.run.springs.elastic.tolist() if j not in self._sprung]
        if far := [j for j in elastic if loud.get(("torque", j), 0.0) > settings().screening.spring_from]:
            if JointStiffness in self._kinds:
                made = made.beside(compute_stiffness_sensitivities(self._ready.run, far))
            if ArmFriction in self._kinds:
                made = made.beside(compute_share_sensitivities(self._ready.run, far))
            self._sprung.update(far)
        if new := _exclude_tried(self._cycles(fit, rest, loud), self._tried):
            periodic = [kind for kind in self._kinds if repeats(kind)]
            made = made.beside(compute_sensitivities(self._ready.run, periodic, new))
            self._tried |= {joint: (*self._tried.get(joint, ()), *cycles) for joint, cycles in new.items()}
        self._made = made
        return made

    def _cycles(self, fit: Fit, rest: Mapping[Channel, Array], energies: Loudness) -> Cycles:
        """Find frequencies per motor turn in the residual of each joint, the strongest first."""
        problem = self._ready.problem
        share = self._ready.null.sensor_share
        # components well above the energy that sensors alone leave
        loud = {
            key
            for key, energy in energies.items()
            if energy > settings().screening.periodic_from * share(key, self._ready.floor)
        }
        residual = assemble_residual(problem.log, fit.run, rest, self._ready.floor)
        found: dict[str, list[float]] = {}
        for j, joint in enumerate(residual.robot.joints):
            peaks: list[tuple[float, float]] = []
            if ("torque", j) in loud:
                # highest peaks of ripple at one amplitude and of ripple in proportion to the torque
                for amplitude, count in _LOOKED_FOR:
                    peaks += _find_peaks(
                        compute_turn_spectrum(residual, "torque", joint, joint, amplitude=amplitude), count
                    )
                peaks += [(0.0, frequency) for frequency in _SHAFT]
            # behind the gearbox, where a gear that errs moves tool and encoder, the highest peak alone
            behind = [(c, k) for c, k in loud if c == "tool" or (c, k) == ("link", j)]
            shown = [
                _find_peaks(compute_turn_spectrum(residual, c, components(c, residual.robot)[k], joint), 1)
                for c, k in behind
            ]
            peaks += sorted((peak for one in shown for peak in one), reverse=True)[:1]
            found[joint] = [frequency for _, frequency in sorted(peaks, reverse=True)]
        return found


def _exclude_tried(cycles: Cycles, tried: Cycles) -> dict[str, tuple[float, ...]]:
    """Keep frequencies that were not tried, nor one nearby, each once; joints without any are left out."""
    new: dict[str, tuple[float, ...]] = {}
    for joint, frequencies in cycles.items():
        for frequency in frequencies:
            known = (*tried.get(joint, ()), *new.get(joint, ()))
            apart = _SHAFT_APART if frequency in _SHAFT else _APART
            if all(abs(frequency - other) >= apart for other in known):
                new[joint] = (*new.get(joint, ()), frequency)
    return new


def _find_peaks(spectrum: Spectrum | None, count: int) -> list[tuple[float, float]]:
    """Find the highest peaks of a spectrum, as share and frequency; empty where a motor turns too little for one."""
    if spectrum is None:
        return []
    frequency, share = spectrum.frequency, spectrum.share
    left, peaks = share.copy(), []
    for _ in range(count):
        best = int(np.argmax(left))
        peaks.append((float(share[best]), float(frequency[best])))
        left[np.abs(frequency - frequency[best]) < _APART] = 0.0
    return peaks

r"""NARX feed-forward: friction as a small recurrent network of past speeds and its own past outputs.

Idea and source: thesis 6.2 with (6.19) and (6.20), which takes the first form from its reference [22]. Three sigmoid
neurons per motor, an offset and no linear term; `ffgym.diagnosis.identification.narx.NarxModel` has the equation, and
the regressors beyond the thesis. As feed-forward it is simulated on the reference speed: past outputs are its own,
never measured ones. It is fitted as in thesis 6.2.3, by Levenberg-Marquardt on the one-step prediction of the torque
that was missing along the realised motion (`ffgym.agents.supervised`), which is friction before all.

Prediction is not simulation. At 4 ms the last torque is a fair guess of the next one, so that a network with y(k-1) can
predict well and still drift once it runs on its own outputs (the thesis finds its models worse in simulation on other
data). `Errors` shows both.

Run it:

    ffgym demo --agents none lugre_dynamic narx

Logged: see `ffgym.agents.supervised.Supervised`.

Departures from the source: torque estimated from trials instead of data from a LuGre model; motions are weighted by
their noise, as in `ffgym.agents.residual_torque`; several random starts, of which the one is kept that *simulates*
best along the trials, since the best in prediction may drift; 200 evaluations at most instead of 1000 iterations;
sampled at the control step of 4 ms instead of 0.5 ms.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Self, final

import numpy as np

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.law_files import StoredLaw
from ffgym.agents.supervised import MotorRecord, Supervised, learn
from ffgym.agents.trials import Trial, every_speed
from ffgym.control import CausalLaw, LawStyle, Window
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx import ARRAYS, NarxModel, Regressors, Samples, Structure, best_simulating
from ffgym.paths import Reference


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NARX(CausalLaw, StoredLaw):
    """One network per motor, run on its own outputs."""

    model: NarxModel
    name: str = "narx"
    kind: ClassVar[str] = "narx"

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return self.model.n_joints

    def initial_memory(self, window: Window) -> Array:
        """Return speed at the start, relaxed slip elements, outputs of zero, shape (..., N M)."""
        return self.model.hold_memory(window.motor_dq[..., 0, :])

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Run the networks one sample on, on their own outputs.

        Raises:
            FFGymError: if the reference is sampled at another time step than the network was fitted at.
        """
        if not self.model.is_sampled_at(window.dt):
            raise FFGymError(
                f"Law {self.name!r} was fitted to samples every {self.model.dt:g} s; the reference has one every "
                f"{window.dt:g} s. Fit it to trials of this controller."
            )
        return self.model.advance(memory, window.motor_dq[..., 1, :])

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """Return name, regressors and time step, and the weights."""
        settings = {"name": self.name, "regressors": asdict(self.model.regressors), "dt": self.model.dt}
        return settings, {name: getattr(self.model, name) for name in ARRAYS}

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """Rebuild the network from `parts`."""
        regressors = Regressors(**settings["regressors"])
        return cls(name=settings["name"], model=NarxModel(regressors=regressors, dt=settings["dt"], **arrays))


N_EVALUATIONS = 200
"""Largest number of evaluations of the residual per start. Chosen: 1000, as in thesis 6.2.3, simulate no better and
take far longer."""
N_STARTS = 5
"""Random starts of the fit. Chosen: fits from different starts end in different minima."""
N_TRIALS = 2
"""Trials to learn from. Chosen, as for the residual torque model."""


def learn_narx(
    trial: Trial,
    references: Sequence[Reference],
    rng: np.random.Generator,
    structure: Structure | None = None,
    n_trials: int = N_TRIALS,
) -> Supervised[NARX]:
    """Learn the NARX network of a machine from trials along `references`; `rng` draws the starts of the fits.

    Raises:
        FFGymError: if there is no motion, or a number is out of range.
    """
    structure = structure or Structure()

    def fit(records: Sequence[MotorRecord]) -> NARX:
        samples = [samples_of(record) for record in records]
        return NARX(model=best_simulating(samples, structure, rng, N_STARTS, n_evaluations=N_EVALUATIONS))

    return learn(trial, references, fit, n_trials)


def samples_of(record: MotorRecord) -> Samples:
    """Turn a record into samples of the fit: standstill is simulated, but not scored."""
    return Samples(
        dt=record.dt,
        motor_dq=record.motor_dq,
        torque=record.torque,
        scored=record.moving,
        noise=record.noise,
    )


declare(
    AgentEntry(
        name="narx",
        title="NARX network",
        about="A recurrent network of three neurons per motor, fitted to the torque that was missing.",
        track="causal",
        order=8,
        page="narx.md",
        style=LawStyle(label="NARX network", colour="#56B4E9", marker="*", line="-."),
        make=lambda setting: (
            learn_narx(setting.trial, every_speed(setting.arm), np.random.default_rng(setting.seed)).law
        ),
        learns=True,
    )
)

r"""NARX feed-forward: friction as a small recurrent network of past speeds and its own past outputs.

Idea and source: thesis 6.2 with (6.19) and (6.20), which takes the first form from its reference [22]. Three sigmoid
neurons per motor, an offset and no linear term; `ffgym.diagnosis.identification.narx.NarxModel` has the equation, and
the regressors beyond the thesis. As feed-forward it is simulated on the reference speed: past outputs are its own,
never measured ones.

Run it:

    ffgym demo --agents none lugre_dynamic narx

Logged: see `ffgym.agents.fitting.supervised.Supervised`. How it is fitted, and what departs from the source:
`ffgym.agents.fitting.narx_fit`.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Self, final

from ffgym.agents.common.law_files import StoredLaw
from ffgym.control import CausalLaw, Window
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx import ARRAYS, NarxModel, Regressors


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NARX(CausalLaw, StoredLaw):
    """One network per motor, run on its own outputs."""

    model: NarxModel
    name: str = "narx"
    kind: ClassVar[str] = "narx"

    @property
    def n_joints(self) -> int:
        """See base class."""
        return self.model.n_joints

    def initial_memory(self, window: Window) -> Array:
        """Speed at the start, relaxed slip elements, outputs of zero, shape (..., N M)."""
        return self.model.remembered(window.motor_dq[..., 0, :])

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """See base class.

        Raises:
            FFGymError: if the reference is sampled at another time step than the network was fitted at.
        """
        if not self.model.is_sampled_at(window.dt):
            raise FFGymError(
                f"Law {self.name!r} was fitted to samples every {self.model.dt:g} s; the reference has one every "
                f"{window.dt:g} s. Fit it to trials of this controller."
            )
        return self.model.advanced(memory, window.motor_dq[..., 1, :])

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """See base class."""
        settings = {"name": self.name, "regressors": asdict(self.model.regressors), "dt": self.model.dt}
        return settings, {name: getattr(self.model, name) for name in ARRAYS}

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> Self:
        """See base class."""
        regressors = Regressors(**settings["regressors"])
        return cls(name=settings["name"], model=NarxModel(regressors=regressors, dt=settings["dt"], **arrays))

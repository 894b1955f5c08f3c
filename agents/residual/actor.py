r"""Network of a residual policy in numpy, which runs a trained policy without torch.

With features x of one motor (`factored`) or of all, layers h = f(W h + b), a last linear layer, and residuals

.. math:: r = \mathrm{clip}(h, -1, 1) \quad\text{or}\quad r = \tanh(h)

An LSTM may stand in front. Arithmetic is float64 on weights that are kept as trained, in float32; sums run within a
row, so that a row's bits do not depend on the others of its batch.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_shape
from ffgym.core.types import Array, BoolArray

ACTIVATIONS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"tanh": np.tanh, "relu": lambda x: np.maximum(x, 0.0)}
)
"""Activations between layers, by name."""
OUTPUTS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"clip": lambda x: np.clip(x, -1.0, 1.0), "tanh": np.tanh}
)
"""Functions that keep residuals within [-1, 1]: `clip` as in PPO, `tanh` as in SAC and TQC."""


_LARGEST = float(np.finfo(np.float32).max)


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearLayer:
    """Linear layer W x + b."""

    weight: Array
    """Shape (outputs, inputs)."""
    bias: Array
    """Shape (outputs,)."""

    def __call__(self, x: Array) -> Array:
        """Apply the layer to inputs (..., inputs), shape (..., outputs)."""
        # products row by row: a matrix product would round by the number of rows
        out: Array = (x[..., None, :] * self.weight).sum(axis=-1) + self.bias
        return out


@dataclass(frozen=True, kw_only=True, eq=False)
class LSTM:
    """One layer of long short-term memory with H cells; rows of the gates in torch's order i, f, g, o."""

    inputs: LinearLayer
    """Layer on the features, 4 H outputs."""
    hidden: LinearLayer
    """Layer on its own last output, 4 H outputs."""

    @property
    def cells(self) -> int:
        """Number of cells H."""
        return self.hidden.weight.shape[1]

    def step(self, x: Array, state: Array) -> tuple[Array, Array]:
        """Compute outputs (..., H) and new state for features (..., F); the state is output and cells, (..., 2, H)."""
        h, c = state[..., 0, :], state[..., 1, :]
        i, f, g, o = np.split(self.inputs(x) + self.hidden(h), 4, axis=-1)
        c = _sigmoid(f) * c + _sigmoid(i) * np.tanh(g)
        h = _sigmoid(o) * np.tanh(c)
        return h, np.stack([h, c], axis=-2)


@dataclass(frozen=True, kw_only=True, eq=False)
class Actor:
    """Network from features to residuals, for any number of robots at once."""

    n_motors: int
    """Number of motors N."""
    layers: tuple[LinearLayer, ...]
    """Layers; all but the last are followed by the activation."""
    activation: str
    """Key of ACTIVATIONS."""
    output: str
    """Key of OUTPUTS."""
    factored: bool
    """True: one network of each motor's own features serves all motors. False: one network sees all of them."""
    lstm: LSTM | None = None
    """LSTM in front of the layers."""

    def __post_init__(self) -> None:
        check_choice("activation", self.activation, list(ACTIVATIONS))
        check_choice("output", self.output, list(OUTPUTS))
        if self.lstm is not None and self.factored:
            raise FFGymError("An LSTM sees all motors at once: factored must be False with one.")
        if not self.layers:
            raise FFGymError("layers must be one or more, got none.")
        width: int | None = None
        if self.lstm is not None:
            check_shape("weight of the LSTM's hidden layer", self.lstm.hidden.weight, (4 * self.lstm.cells, None))
            for layer in (self.lstm.inputs, self.lstm.hidden):
                _check_layer("the LSTM", layer, None, 4 * self.lstm.cells)
            width = self.lstm.cells
        for k, layer in enumerate(self.layers):
            last = k == len(self.layers) - 1
            wanted = (1 if self.factored else self.n_motors) if last else None
            _check_layer(f"layer {k}", layer, width, wanted)
            width = layer.weight.shape[0]

    @property
    def n_features(self) -> int:
        """Number of features of all motors together."""
        first = self.layers[0] if self.lstm is None else self.lstm.inputs
        return first.weight.shape[1] * (self.n_motors if self.factored else 1)

    def initial_state(self, shape: tuple[int, ...] = ()) -> Array:
        """Return the state when an episode begins, shape (*shape, 2, H); H is 0 without an LSTM."""
        return np.zeros((*shape, 2, 0 if self.lstm is None else self.lstm.cells))

    def act(self, features: Array, state: Array, begins: BoolArray | None = None) -> tuple[Array, Array]:
        """Compute residuals (..., N) in [-1, 1] for features (..., N F), and the next state.

        Args:
            features: numbers of all motors, the first motor's in front; rounded to float32, as in training.
            state: state that the last call returned, or `initial_state`.
            begins: True where an episode begins, shape (...,); None is nowhere.
        """
        x = features.astype(np.float32).astype(np.float64)
        if begins is not None:
            state = np.where(begins[..., None, None], 0.0, state)
        if self.lstm is not None:
            x, state = self.lstm.step(x, state)
        if self.factored:
            x = x.reshape(*x.shape[:-1], self.n_motors, -1)
        for layer in self.layers[:-1]:
            x = ACTIVATIONS[self.activation](layer(x))
        x = OUTPUTS[self.output](self.layers[-1](x))
        return (x[..., 0] if self.factored else x), state

    # As parts of a file

    def settings(self) -> dict[str, Any]:
        """Return the settings that JSON can hold."""
        own = {name: getattr(self, name) for name in ("n_motors", "activation", "output", "factored")}
        return own | {"layers": len(self.layers), "lstm": self.lstm is not None}

    def arrays(self) -> dict[str, Array]:
        """Return the weights by name, float32."""
        named = {f"layer_{k}": layer for k, layer in enumerate(self.layers)}
        if self.lstm is not None:
            named |= {"lstm_inputs": self.lstm.inputs, "lstm_hidden": self.lstm.hidden}
        parts = {f"{name}_{part}": getattr(layer, part) for name, layer in named.items() for part in ("weight", "bias")}
        return {name: values.astype(np.float32) for name, values in parts.items()}

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays: Mapping[str, Array]) -> "Actor":
        """Rebuild the actor from `settings` and `arrays`.

        Raises:
            FFGymError: if shapes do not fit.
        """

        def numbers(name: str, *shape: None) -> Array:
            values = check_shape(name, arrays[name], shape)
            if np.any(np.abs(values) > _LARGEST):
                raise FFGymError(f"{name} has numbers beyond {_LARGEST:g}, those of float32, in which it is kept.")
            return values

        def layer(name: str) -> LinearLayer:
            return LinearLayer(weight=numbers(f"{name}_weight", None, None), bias=numbers(f"{name}_bias", None))

        if not isinstance(settings, Mapping):
            raise FFGymError(f"actor = {settings!r} must be an object of settings.")
        own = dict(settings)
        count, recurrent = own.pop("layers"), own.pop("lstm")
        layers = tuple(layer(f"layer_{k}") for k in range(count))
        lstm = LSTM(inputs=layer("lstm_inputs"), hidden=layer("lstm_hidden")) if recurrent else None
        return cls(layers=layers, lstm=lstm, **own)


def _check_layer(name: str, layer: LinearLayer, inputs: int | None, outputs: int | None) -> None:
    weight = check_shape(f"weight of {name}", layer.weight, (outputs, inputs))
    check_shape(f"bias of {name}", layer.bias, (weight.shape[0],))


def _sigmoid(x: Array) -> Array:
    share: Array = 0.5 * (1.0 + np.tanh(0.5 * x))
    return share

"""NARX networks with random weights."""

import numpy as np

from ffgym.diagnosis.identification.narx import NarxModel, Regressors, Structure


def random_network(regressors=None, seed=0, n=2, size=2.0, n_neurons=None) -> NarxModel:
    """A network of `n` motors."""
    rng = np.random.default_rng(seed)
    regressors = regressors or Regressors()
    shape = (n, n_neurons or Structure().n_neurons, regressors.count)
    return NarxModel(
        input_weights=size * rng.normal(size=shape),
        biases=rng.normal(size=shape[:2]),
        output_weights=rng.normal(size=shape[:2]),
        offset=rng.normal(size=n),
        speed_scale=np.full(n, 2.0),
        torque_scale=np.full(n, 0.5),
        regressors=regressors,
        dt=0.004,
    )

"""What is searched for, and what to try next: Optuna's tree-structured Parzen estimator, begun anew for each trial."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from scripts.tuning.record import Trial

Space = Mapping[str, tuple[float, float, bool]]
"""Lowest and highest value of what is searched for, and whether it is drawn evenly in its logarithm."""

_ALL = {"learning_rate": (3e-4, 1e-2, True), "gamma": (0.8, 0.98, False), "first_std": (0.05, 0.4, True)}
_ON_POLICY = _ALL | {"gae_lambda": (0.6, 0.95, False), "clip_range": (0.1, 0.4, False)}
_OFF_POLICY = _ALL | {"first_ent_coef": (1e-3, 1e-1, True), "entropy_per_motor": (-4.0, -1.0, False)}
SPACES: Mapping[str, Space] = MappingProxyType(
    {"ppo": _ON_POLICY, "recurrent_ppo": _ON_POLICY, "sac": _OFF_POLICY, "tqc": _OFF_POLICY}
)
"""Hyper-parameters that are searched for, by algorithm; the final learning rate is a tenth of the first one."""


def proposal(space: Space, trials: Sequence[Trial], seed: int) -> dict[str, float]:
    """What to try after `trials`; these, the seed and nothing else decide it, so a search that was stopped goes on."""
    import optuna
    from optuna.distributions import FloatDistribution
    from optuna.samplers import TPESampler

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    ranges = {name: FloatDistribution(low, high, log=log) for name, (low, high, log) in space.items()}
    draws = int(np.random.SeedSequence([seed, len(trials)]).generate_state(1)[0])
    study = optuna.create_study(direction="minimize", sampler=TPESampler(seed=draws))
    for trial in trials:
        done = optuna.trial.create_trial(params=trial.parameters, distributions=dict(ranges), value=trial.value)
        study.add_trial(done)
    asked = study.ask(dict(ranges))
    return {name: float(asked.params[name]) for name in space}

"""What pages tell of residual policies, and of the true parameters that they lack, from the code and stored results."""

from collections.abc import Iterator

import numpy as np

from ffgym.agents.residual.composition import AHEAD, ERROR_UNIT, LIMIT
from ffgym.agents.residual.plan import DEFAULT_STEPS, ENCODER_BITS, Training
from ffgym.envs.rewards import RelativePathError
from ffgym.leaderboard.comparison.samples import DRAWS
from ffgym.leaderboard.plants import NOMINAL
from scripts.claims.claim import claim
from scripts.claims.told.leaderboard import RESULTS, speeds
from scripts.tables.leaderboard import search_of, stored_rows

CODE = "the code itself"


@claim(CODE)
def features_of_residuals() -> Iterator[str]:
    """What residual policies see, and what they are trained with."""
    *first, last = map(str, AHEAD)
    yield f"clipped to ±{LIMIT:g},"
    for gain in ("K_p", "K_v"):
        yield f"| f_s / {1 / ERROR_UNIT:g} {gain} |"
    yield f"the newest `memory` ({Training.memory}) |"
    yield f"{', '.join(first)} and {last} ahead |"
    yield f"through {ENCODER_BITS}-bit resolvers"
    yield f"-ln(1 + path error / {1e6 * RelativePathError.scale:.0f} µm)"
    steps = [f"{DEFAULT_STEPS[name]:,}".replace(",", " ") for name in ("ppo", "sac")]
    yield f"has {steps[0]} steps with PPO and recurrent PPO, and {steps[1]} with SAC and TQC."


@claim("python -m scripts.tune, with the options of each search")
def searches_with_drives() -> Iterator[str]:
    """Machines of the searches, and what on-policy learning finds."""
    ppo, recurrent = (search_of(name) for name in ("ppo", "recurrent_ppo"))
    yield f"are trained on {ppo['search']['training']['machines']} drawn machines"
    near = [sum(trial["value"] > np.log(0.95) for trial in search["trials"]) for search in (ppo, recurrent)]
    assert near == [9, 8] == [len(ppo["trials"]) - 1, len(recurrent["trials"])]
    yield "nine trials of ten, and all eight of recurrent PPO, end within 5 % of their base or behind it"


@claim(RESULTS)
def what_residuals_cannot_gain() -> Iterator[str]:
    """Errors of the base on the nominal robot, and the delay that a single training bears."""
    base = speeds(NOMINAL, "elastic").values()
    yield f"makes its errors of {min(base):.0f} to {max(base):.0f} um"
    by_path = [name for name, row in stored_rows().items() if row.seeded and not name.endswith("drives")]
    (delay,) = (each.delay_ms for name in by_path for each in stored_rows()[name].margins if each.delay_ms)
    yield f"one training bears a delay, of {delay:g} ms."


@claim(RESULTS)
def what_the_truth_is_worth() -> Iterator[str]:
    """Path errors on drawn robots of laws that know nominal and true parameters."""
    found = {name: speeds(DRAWS, name) for name in ("lugre_dynamic", "elastic", "oracle")}
    for at in (10.0, 40.0, 100.0):
        lugre, elastic, oracle = (found[name][at] for name in found)
        yield f"| {at:g} mm/s | {lugre:.0f} | {elastic:.1f} | {oracle:.1f} |"
    kept = [
        100 * (lugre - elastic) / (lugre - oracle)
        for lugre, elastic, oracle in zip(*(found[name].values() for name in found), strict=True)
    ]
    yield (
        f"keeps {kept[2]:.0f} % of the oracle's gain over LuGre at 40 mm/s and {kept[4]:.0f} % at 100 mm/s, where "
        f"springs matter most, but only {kept[0]:.0f} % at 10 mm/s"
    )

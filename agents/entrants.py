"""Everybody on the leaderboard: laws of the catalogue, and what was trained and ships with the package."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType

from ffgym.agents.artefacts import Manifest, manifest_of, path_of
from ffgym.agents.catalogue import CATALOGUE, Entry, Setting
from ffgym.agents.common.law_files import load_law
from ffgym.agents.common.law_policy import LawPolicy
from ffgym.agents.common.shared_trials import learn_together
from ffgym.agents.common.trials import CountedTrial, RigTrial, Trial, measured
from ffgym.agents.model import model_law
from ffgym.agents.random_torque import RandomTorque
from ffgym.agents.residual.policy import load_policy
from ffgym.agents.submission import LOADERS
from ffgym.control import CausalLaw, FeedForwardLaw, Policy
from ffgym.leaderboard.entrants import Entrant, Maker, Ready, Registry, one_by_one
from ffgym.leaderboard.plants import DRAW, NOMINAL, TestPlant
from ffgym.leaderboard.submission.entrant import entrant_of
from ffgym.leaderboard.tasks import Task, references_of

REGISTRY = Registry("ffgym.agents.entrants:ENTRANTS", maker="ffgym.agents.entrants:submitted")
"""Where other processes find them, and what makes an entrant of a submission."""
SEEDS = (0, 1, 2, 3, 4)
"""Of every row that a seed changes."""
_PRACTISED = "per task"
"""Track of laws that practise what is scored."""
FITTED = "model_fitted"
"""Row of feed-forward from models that were fitted to recordings of the workcell."""

_ABOUT = {
    "none": "No added torque: the servo and the rigid-body feed-forward that every robot has.",
    "random": "Uniform random torque up to breakaway torque: what knowing nothing is worth.",
    "lugre_static": "Friction of the static LuGre model at the speed of the reference, nominal parameters.",
    "lugre_dynamic": "Friction of the dynamic LuGre model along the reference, nominal parameters.",
    "bsn_static": "One B-spline network over speed per motor, learned from the feedback as in the thesis.",
    "bsn_extended": "Two B-spline networks per motor, for speeding up and for slowing down, as in the thesis.",
    "bsn_extended_prior": "The extended network, begun from an estimated Coulomb torque and learned at two speeds.",
    "mlp_fel": "A small perceptron per motor, learned from the feedback error.",
    "narx": "A recurrent network of three neurons per motor, fitted to the torque that was missing.",
    "residual_gp": "A line and a Gaussian process per motor, fitted to the torque that was missing.",
    "ilc_motor": "Iterative learning of each motion from its motor errors: ten trials of every circle that is scored.",
    "ilc_tcp": "Iterative learning of each motion from the tool's errors: ten trials of every circle that is scored.",
    "elastic": "Inverse dynamics with flexible joints and dynamic LuGre friction, nominal parameters.",
    "oracle": "Elastic feed-forward with the machine's true parameters, which no controller knows. Not ranked.",
}
"""What laws do and what they learned from."""

_EACH_MOTOR = "one small network for all motors"
RESIDUALS: Mapping[str, tuple[str, str, str, str]] = MappingProxyType(
    {
        "ppo_elastic": ("ppo", "elastic", "PPO on elastic", _EACH_MOTOR),
        "sac_elastic": ("sac", "elastic", "SAC on elastic", _EACH_MOTOR),
        "tqc_elastic": ("tqc", "elastic", "TQC on elastic", _EACH_MOTOR),
        "recurrent_ppo_elastic": (
            "recurrent_ppo",
            "elastic",
            "recurrent PPO on elastic",
            "an LSTM that sees all motors",
        ),
        "ppo_elastic_memory": (
            "ppo",
            "elastic",
            "PPO on elastic, memory",
            "one small network that sees the last samples",
        ),
        "ppo_lugre": ("ppo", "lugre_dynamic", "PPO on dynamic LuGre", _EACH_MOTOR),
        "ppo_none": ("ppo", "none", "PPO on nothing", _EACH_MOTOR),
    }
)
"""Trained residual policies: algorithm, base, title, kind of network."""


def _law(entry: Entry) -> Entrant:
    """An entry of the catalogue: read from artefacts if there are some, made where it runs otherwise."""
    manifest = manifest_of(entry.name)
    practises = entry.track == _PRACTISED
    again = f"ffgym leaderboard --agents {entry.name}" if practises else None
    return Entrant(
        name=entry.name,
        title=entry.title,
        track=entry.track,
        about=_ABOUT[entry.name],
        page=entry.page,
        seeds=SEEDS if practises else (0,) if manifest is None else manifest.seeds,
        command=again if manifest is None else manifest.command,
        ranked=entry.track != "oracle",
        slow=practises,
        artefact=partial(_sha256, manifest),
        ready=_maker(entry, manifest),
    )


def _maker(entry: Entry, manifest: Manifest | None) -> Maker:
    if entry.track == _PRACTISED:
        return partial(_practised, entry)
    return one_by_one(partial(_made, entry) if manifest is None else partial(_read, manifest, _stored_law))


def _made(entry: Entry, plant: TestPlant, seed: int, tasks: tuple[Task, ...]) -> Ready | None:
    """A law from the description, from trials, or from the truth; None where that is shut away."""
    if entry.track == "oracle" and plant.truth is None:
        return None
    trial = CountedTrial(RigTrial(rig=measured(plant.rig), seed=seed))
    law = entry.make(Setting(arm=plant.rig.arm, trial=trial, truth=plant.truth, seed=seed))
    return Ready(law=law, timed=_timed(law), robot_seconds=trial.robot_seconds)


def _practised(entry: Entry, plant: TestPlant, seeds: Sequence[int], tasks: tuple[Task, ...]) -> list[Ready | None]:
    """A law that practised the tasks, seen through the machine's sensors; all seeds learn side by side."""
    references = references_of(plant.rig.arm, tasks)

    def learned(seed: int, trial: Trial) -> Ready:
        counted = CountedTrial(trial)
        law = entry.make(Setting(arm=plant.rig.arm, trial=counted, references=references, seed=seed))
        return Ready(law=law, robot_seconds=counted.robot_seconds)  # learned beforehand, so that nothing is timed

    found = learn_together(measured(plant.rig), {seed: (seed, partial(learned, seed)) for seed in seeds})
    return [found[seed] for seed in seeds]


def _read(
    manifest: Manifest,
    load: Callable[[Path, TestPlant], FeedForwardLaw | Policy],
    plant: TestPlant,
    seed: int,
    tasks: tuple[Task, ...],
) -> Ready | None:
    """A trained agent; on drawn plants it is what it was on the nominal one. None if it was not trained for a plant."""
    artefact = manifest.find(_learned_on(plant.name), seed)
    if artefact is None:
        return None
    loaded = load(path_of(manifest.name, artefact), plant)
    law, policy = (loaded, None) if isinstance(loaded, FeedForwardLaw) else (None, loaded)
    return Ready(
        law=law,
        policy=policy,
        timed=None if law is None else _timed(law),
        artefact=artefact.sha256,
        robot_seconds=artefact.robot_seconds,
        env_steps=artefact.env_steps,
    )


def _timed(law: FeedForwardLaw) -> Policy | None:
    """A law as what decides sample by sample, if it can."""
    return LawPolicy(make=lambda robot: law, preview=law.preview) if isinstance(law, CausalLaw) else None


def _sha256(manifest: Manifest | None, plant: str, seed: int) -> str | None:
    """What the artefact for a plant is known by."""
    artefact = None if manifest is None else manifest.find(_learned_on(plant), seed)
    return None if artefact is None else artefact.sha256


def _learned_on(plant: str) -> str:
    """Plant whose artefact runs on a plant: drawn ones are met with what was learned on the nominal one."""
    return NOMINAL if plant.startswith(DRAW) else plant


def _stored_law(path: Path, plant: TestPlant) -> FeedForwardLaw:
    return load_law(path)


def _modelled(path: Path, plant: TestPlant) -> FeedForwardLaw:
    return model_law(path, plant.rig.arm, FITTED)


def _stored_policy(path: Path, plant: TestPlant) -> Policy:
    return load_policy(path)


def _fitted(manifest: Manifest) -> Entrant:
    return Entrant(
        name=FITTED,
        title="fitted and diagnosed model",
        track="causal, nominal parameters",
        about="Elastic feed-forward from a model whose friction, rotors, masses and springs were fitted to 88 s of "
        "recordings of the machine, and which has the effects that a diagnosis of these recordings found.",
        page="model.md",
        seeds=manifest.seeds,
        command=manifest.command,
        artefact=partial(_sha256, manifest),
        ready=one_by_one(partial(_read, manifest, _modelled)),
    )


def _residual(name: str, manifest: Manifest) -> Entrant:
    _, base, title, network = RESIDUALS[name]
    return Entrant(
        name=name,
        title=title,
        track="causal, nominal parameters",  # without a base too: it was trained on robots about the nominal one
        about=f"A bounded residual torque on {CATALOGUE[base].title}: {network}, trained in simulation at p1 on robots "
        f"drawn about the nominal one; it never met the machine that it is scored on.",
        page="residual.md",
        base=base,
        seeds=manifest.seeds,
        command=manifest.command,
        artefact=partial(_sha256, manifest),
        learning_curve=lambda: manifest.learning_curve,
        ready=one_by_one(partial(_read, manifest, _stored_policy)),
    )


def _random() -> Entrant:
    def ready(plant: TestPlant, seed: int, tasks: tuple[Task, ...]) -> Ready | None:
        return Ready(law=RandomTorque(seed=seed))

    about, track = _ABOUT["random"], "causal"
    maker = one_by_one(ready)
    return Entrant(
        name="random", title="random torque", track=track, about=about, seeds=SEEDS, ranked=False, ready=maker
    )


def submitted(path: Path) -> Entrant:
    """Entrant of a submission, see `entrant_of`."""
    return entrant_of(path, LOADERS)


def _everybody() -> list[Entrant]:
    laws = [_law(entry) for name, entry in CATALOGUE.items() if name != "model"]  # without a file it is elastic
    fitted = manifest_of(FITTED)
    models = [] if fitted is None else [_fitted(fitted)]
    trained = {name: manifest_of(name) for name in RESIDUALS}
    residuals = [_residual(name, manifest) for name, manifest in trained.items() if manifest is not None]
    return [laws[0], _random(), *laws[1:-1], *models, *residuals, laws[-1]]


ENTRANTS: Mapping[str, Entrant] = MappingProxyType({entrant.name: entrant for entrant in _everybody()})
"""By name, in the order of tables."""

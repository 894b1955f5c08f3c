"""Families on the curve of adaptation: each makes a law for a machine from motion within a budget.

Laws with nominal numbers move nothing. Learners spend the budget on laps of one circle, from `BROAD` laps on laps of
one radius at three speeds, since a network over speed knows nothing of speeds that it never met, and from `BROADEST` on
laps of three radii. Those that have learned all they can before the budget ends leave the rest.

Families that stand nowhere else are agents, too: commands and the leaderboard make them on a machine, after one lap.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from ffgym.agents.amortised.estimator import Estimator, adapt
from ffgym.agents.artefacts import ANYWHERE, TRAINED, locate_artefact, read_manifest
from ffgym.agents.bspline import ExtendedBSN
from ffgym.agents.declaration import AgentEntry, AgentSetting, declare
from ffgym.agents.elastic import elastic_law
from ffgym.agents.fitted import NAME as FITTED
from ffgym.agents.fitted import fit_model
from ffgym.agents.iterative import TRIALS
from ffgym.agents.iterative_basis import learn_basis_weights
from ffgym.agents.lffc import thesis_training
from ffgym.agents.lugre import dynamic_lugre
from ffgym.agents.residual_torque import learn_residual_torque
from ffgym.agents.trials import RigTrial, add_sensors
from ffgym.control import FeedForwardLaw, LawStyle, NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.adaptation.protocol import LAP, AdaptationSetting, Adapter, lap, practice_motion, practice_set
from ffgym.paths import SPEEDS, Reference
from ffgym.simulation.protocols import load_protocols, plan_session

LAPS = (1, 3, 10, 36, 180, 538)
"""Budgets of learners in laps: one, three, then a quarter of a minute, one, five and fifteen minutes."""
BROAD, BROADEST = 10, 36
"""Laps from which practice is at all speeds of the thesis, and with all its radii."""
FIT_LAPS = (1, 3, 10, 53)
"""Budgets of the fitted model in laps. The last one, 88.6 s, is as long as the protocol `diagnosis`, which it records
then in place of circles: the motions from which `ffgym improve --fit` fits a model. A fit to more takes minutes."""
GP_TRIALS = 3
"""Largest number of trials of the residual torque model, which more do not change."""


def practice_for(setting: AdaptationSetting) -> tuple[list[Reference], int]:
    """Choose the motions of one trial, and the number of trials that the budget allows."""
    one, left = lap(setting.arm), setting.trial.left + 1e-9
    references = [one]
    if left >= BROAD * one.duration:
        references = [practice_motion(setting.arm, LAP[0], speed) for speed in SPEEDS]
    if left >= BROADEST * one.duration:
        references = practice_set(setting.arm)
    return references, int(left / sum(each.duration for each in references))


def _learn_splines(setting: AdaptationSetting) -> FeedForwardLaw:
    """Train an extended B-spline network as the thesis does."""
    references, trials = practice_for(setting)
    n = setting.arm.robot.n_joints
    training = replace(thesis_training(n), iterations=trials - 1)
    learning = training.learn(ExtendedBSN.zero(n), references, setting.trial)
    # the best network that was tried; of a single trial, which tried none, the first update
    return learning.network if trials == 1 else learning.best


def _learn_residual(setting: AdaptationSetting) -> FeedForwardLaw:
    """Fit the residual torque model."""
    references, trials = practice_for(setting)
    return learn_residual_torque(setting.trial, references, min(trials, GP_TRIALS)).law


def _learn_basis(setting: AdaptationSetting) -> FeedForwardLaw:
    """Learn weights of basis functions by iterative learning."""
    references, trials = practice_for(setting)
    return learn_basis_weights(
        setting.arm, elastic_law(setting.arm), references, setting.trial, trials=min(trials, TRIALS)
    )


def _fit_model(setting: AdaptationSetting) -> FeedForwardLaw:
    """Fit the nominal model to circles, or to the motions of the protocol `diagnosis` where the budget allows them."""
    references, trials = practice_for(setting)
    everything = [each.reference for each in plan_session(setting.arm, load_protocols("diagnosis"))]
    if setting.trial.left >= sum(each.duration for each in everything):
        references, trials = everything, 1
    return fit_model(setting.arm, references, setting.trial, trials)


def _adapt_amortised(name: str, setting: AdaptationSetting) -> FeedForwardLaw:
    """Estimate with the trained network of a seed."""
    return adapt(_load_estimator(name, setting.seed), setting, name)


def _load_estimator(name: str, seed: int) -> Estimator:
    manifest = read_manifest(name)
    artefact = None if manifest is None else manifest.find(ANYWHERE, seed)
    if artefact is None:
        raise FFGymError(
            f"There is no estimator {name!r} with seed {seed} in {TRAINED}: run python -m scripts.train_estimator."
        )
    return Estimator.load(locate_artefact(name, artefact))


def _find_sha256(name: str, seed: int) -> str | None:
    manifest = read_manifest(name)
    artefact = None if manifest is None else manifest.find(ANYWHERE, seed)
    return None if artefact is None else artefact.sha256


def _declare_amortised(name: str, title: str, about: str) -> Adapter:
    manifest = read_manifest(name)
    adapter: Callable[[AdaptationSetting], FeedForwardLaw] = partial(_adapt_amortised, name)
    return Adapter(
        name=name,
        title=title,
        about=about,
        adapt=adapter,
        laps=(1, 3),
        seeds=(0,) if manifest is None else manifest.seeds,
        artefact=partial(_find_sha256, name),
    )


ADAPTERS: tuple[Adapter, ...] = (
    Adapter(
        name="none",
        title="no compensation",
        about="The existing controller alone.",
        adapt=lambda setting: NoCompensation(),
    ),
    Adapter(
        name="lugre_dynamic",
        title="dynamic LuGre",
        about="Friction of the nominal robot, thesis chapter 4.",
        adapt=lambda setting: dynamic_lugre(setting.arm.robot),
    ),
    Adapter(
        name="elastic",
        title="elastic feed-forward",
        about="Inverse dynamics with flexible joints and friction on both sides of them, nominal numbers.",
        adapt=lambda setting: elastic_law(setting.arm),
    ),
    Adapter(
        name="bsn_extended",
        title="B-spline learning",
        about="Two B-spline networks over speed per motor, learned from zero as in the thesis.",
        adapt=_learn_splines,
        laps=LAPS,
    ),
    Adapter(
        name="residual_gp",
        title="Gaussian process",
        about="A line and a Gaussian process per motor, fitted to the torque that was missing.",
        adapt=_learn_residual,
        laps=LAPS,
    ),
    Adapter(
        name="ilc_basis",
        title="iterative learning in basis functions",
        about="Weights of torques of the nominal model, on elastic feed-forward, learned from the errors of the tool.",
        adapt=_learn_basis,
        laps=LAPS[:-1],
    ),
    Adapter(
        name=FITTED,
        title="model fitted to recordings",
        about="Elastic feed-forward with all numbers of the model fitted to torques of motors and the way of the tool.",
        adapt=_fit_model,
        laps=FIT_LAPS,
    ),
    _declare_amortised(
        "amortised_motors",
        "amortised estimator, motors",
        "A network estimates the numbers of the machine from feedback torques of laps of one circle.",
    ),
    _declare_amortised(
        "amortised_recurrent",
        "recurrent estimator, motors",
        "A recurrent network reads these torques in their order, as the student of a law with the true numbers.",
    ),
    _declare_amortised(
        "amortised",
        "amortised estimator, motors and tracker",
        "A network estimates the numbers of the machine from torques and the tool's way of laps of one circle.",
    ),
)
"""All families, in the order of tables."""


def _practise_lap(adapter: Adapter, setting: AgentSetting) -> FeedForwardLaw:
    """Adapt to the machine of a setting within one lap, seen through the sensors of its robot.

    Raises:
        FFGymError: if the robot cannot follow the circle of practice, or the estimator is for another robot.
    """
    trial = setting.trial
    if isinstance(trial, RigTrial):
        trial = replace(trial, rig=add_sensors(trial.rig))
    try:
        return adapter.practise(setting.arm, trial, laps=1, seed=setting.seed)[0]
    except FFGymError as error:
        raise FFGymError(f"{adapter.name} cannot practise on {setting.robot.name}: {error}") from error


def _agent(name: str, page: str, order: float, colour: str, marker: str, on_leaderboard: bool = True) -> AgentEntry:
    """Make the agent of a family that adapts within one lap."""
    adapter = next(each for each in ADAPTERS if each.name == name)
    return AgentEntry(
        name=name,
        title=adapter.title,
        about=f"{adapter.about} After one lap of one circle on the machine.",
        track="causal, nominal parameters",
        order=order,
        page=page,
        style=LawStyle(label=adapter.title, colour=colour, marker=marker),
        make=partial(_practise_lap, adapter),
        base="elastic",
        load=None,
        needs_arm=True,
        on_leaderboard=on_leaderboard,
    )


# Two stand on the curve alone: a law that needs the whole motion beforehand, and what equals amortised_motors there.
declare(
    _agent("ilc_basis", "iterative.md", 14.2, "#A6611A", "X", on_leaderboard=False),
    _agent(FITTED, "fitted.md", 14.3, "#35978F", "D"),
    _agent("amortised_motors", "amortised.md", 14.4, "#8073AC", "<"),
    _agent("amortised_recurrent", "amortised.md", 14.5, "#542788", ">", on_leaderboard=False),
    _agent("amortised", "amortised.md", 14.6, "#B2ABD2", "*"),
)

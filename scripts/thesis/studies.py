"""Everything that the claims and figures need, simulated when it is first asked for, and only then."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import cached_property

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.catalogue import CATALOGUE, find_entry, make_law
from ffgym.agents.declaration import AgentEntry, AgentSetting
from ffgym.agents.lffc import Learning, thesis_training
from ffgym.agents.trials import CountedTrial, thesis_motions, training_motions
from ffgym.control import DynamicLuGreExact, FeedForwardLaw, NoCompensation
from ffgym.diagnosis.identification.narx import Samples
from ffgym.envs.machines import make_rig
from ffgym.paths import SPEEDS, Reference
from ffgym.published import ESTIMATION_RECORDS
from ffgym.robot import RobotDescription, load_robot
from ffgym.simulation import Rig
from ffgym.simulation.run import Progress
from ffgym.studies import CircleStudy, OneAxisStudy, circle_references, circle_study, one_axis_study
from scripts.thesis.measured_friction import ALL_RECORDS, MeasuredFriction, measure_friction
from scripts.thesis.narx import EXTENDED, LINEAR, PUBLISHED, Candidate, NarxFit, fit_narx, narx_records, reach_records

Stage = Callable[[str, str], AbstractContextManager[Progress]]
"""Called with a title and a unit when a piece of work begins; yields what is told of its progress."""

SEED = 0
"""Seed of sensor noise, of the first weights of NARX networks, and of starts and resamples of identified friction;
nothing else is random."""

IDENTIFIED = "lugre_identified"
"""Name of dynamic LuGre with identified parameters, beside the one with old ones."""

WORKCELL = "workcell:thesis"
"""Name of the machine that stands for the thesis' real robot in chapter 6."""

FAST = SPEEDS[1]
"""TCP speed [m/s] of the second training, thesis 5.4.2."""
FASTEST = SPEEDS[2]
"""TCP speed [m/s] of a third training, which the thesis leaves out."""


def silent(title: str, unit: str) -> AbstractContextManager[Progress]:
    """A stage that nobody watches."""
    return nullcontext(lambda done, total: None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Contender:
    """A member of the agents' catalogue, ready to run, with what it needed to try."""

    entry: AgentEntry
    law: FeedForwardLaw
    trials: int
    robot_seconds: float


def contender(name: str, setting: AgentSetting) -> Contender:
    """Make a member of the catalogue; learning members run their trials here."""
    counted = CountedTrial(setting.trial)
    entry = find_entry(name)
    law = make_law(name, replace(setting, trial=counted))
    return Contender(entry=entry, law=law, trials=counted.trials, robot_seconds=counted.robot_seconds)


class ThesisStudies:
    """The nominal robot, the one-axis model and a workcell, with the tests of the thesis; all randomness is seeded."""

    def __init__(self, *, n_threads: int = 0, stage: Stage = silent) -> None:
        """Make studies of which nothing has been simulated; `stage` is told of what goes on.

        Threads of the engine are as many as there are cores for 0; results are the same at any number.
        """
        self.n_threads = n_threads
        self.stage = stage

    @cached_property
    def robot(self) -> RobotDescription:
        """Six axes, elastic joints, LuGre friction."""
        return load_robot("irb4600_60_205")

    @cached_property
    def axis(self) -> RobotDescription:
        """One rigid axis with LuGre friction."""
        return load_robot("one_axis")

    @cached_property
    def workcell(self) -> Rig:
        """The machine that stands for the thesis' real robot in chapter 6, under its controller."""
        return make_rig(WORKCELL)

    @cached_property
    def lugre_sines(self) -> OneAxisStudy:
        """Sine test with no compensation and both LuGre laws."""
        return one_axis_study(self.axis)

    @cached_property
    def lugre_circles(self) -> CircleStudy:
        """The 36 circles with no compensation and both LuGre laws."""
        return self._circles("circles with LuGre", self.robot)

    @cached_property
    def setting(self) -> AgentSetting:
        """The robot as those who learn know it."""
        return AgentSetting.of(self.robot, n_threads=self.n_threads)

    @cached_property
    def axis_learning(self) -> dict[str, Learning]:
        """Both B-spline networks, by name, after learning on the sine of 1 Hz (thesis 5.3.1)."""
        setting = AgentSetting.of(self.axis, n_threads=self.n_threads)
        return self._learning(setting, thesis_motions(setting.arm), "sine of 1 Hz")

    @cached_property
    def learning(self) -> dict[str, Learning]:
        """Both networks after learning at p1 at 10 mm/s (thesis 5.3.2)."""
        return self._learning(self.setting, thesis_motions(self.setting.arm), "10 mm/s")

    @cached_property
    def fast_learning(self) -> dict[str, Learning]:
        """Both networks after learning at p1 at 40 mm/s (thesis 5.4.2)."""
        return self._learning(self.setting, training_motions(self.setting.arm, speeds=[FAST]), "40 mm/s")

    @cached_property
    def bsn_sines(self) -> OneAxisStudy:
        """Sine test with no compensation and both networks."""
        laws = [learning.best for learning in self.axis_learning.values()]
        return one_axis_study(self.axis, laws=[NoCompensation(), *laws])

    @cached_property
    def bsn_circles(self) -> CircleStudy:
        """The 36 circles with no compensation, dynamic LuGre, and both networks as trained at 10 mm/s."""
        return self._with_networks(self.learning, SPEEDS, "10 mm/s")

    @cached_property
    def fast_bsn_circles(self) -> CircleStudy:
        """The 12 circles at 40 mm/s with no compensation, dynamic LuGre, and both networks as trained at 40 mm/s."""
        return self._with_networks(self.fast_learning, [FAST], "40 mm/s")

    @cached_property
    def fastest_learning(self) -> dict[str, Learning]:
        """Both networks after learning at p1 at 100 mm/s, which the thesis did not do."""
        return self._learning(self.setting, training_motions(self.setting.arm, speeds=[FASTEST]), "100 mm/s")

    @cached_property
    def networks_of_40(self) -> CircleStudy:
        """The 36 circles as in `bsn_circles`, with networks trained at 40 mm/s (thesis 5.5: used at other speeds)."""
        return self._with_networks(self.fast_learning, SPEEDS, "40 mm/s")

    @cached_property
    def networks_of_100(self) -> CircleStudy:
        """The same with networks trained at 100 mm/s."""
        return self._with_networks(self.fastest_learning, SPEEDS, "100 mm/s")

    @cached_property
    def joint_1(self) -> MeasuredFriction:
        """Friction of joint 1 of the workcell, identified as in thesis 6.1."""
        return self._friction("friction of joint 1", self.workcell.robot.joints[:1], ALL_RECORDS)

    @cached_property
    def all_joints(self) -> MeasuredFriction:
        """Friction of all joints of the workcell, from ladders and the records of set D."""
        return self._friction("friction of all joints", self.workcell.robot.joints, ESTIMATION_RECORDS)

    @cached_property
    def reidentified_circles(self) -> CircleStudy:
        """Circles at 10 and 40 mm/s on it: no compensation, dynamic LuGre with old and with identified parameters."""
        rig, speeds = self.workcell, SPEEDS[:2]
        laws = [NoCompensation(), DynamicLuGreExact(rig.robot.friction)]
        old = self._circles("circles on the workcell, old parameters", rig, laws, speeds)
        law = DynamicLuGreExact(self.all_joints.found.friction)
        new = self._circles("circles on the workcell, identified", rig, [law], speeds)
        return old.join(new.rename(law.name, IDENTIFIED))

    @cached_property
    def narx_records(self) -> dict[str, Samples]:
        """Sines of thesis 6.2.2 and Table 6.1 with the friction of the LuGre model, by name."""
        return narx_records(self.axis.friction)

    @cached_property
    def narx_reach(self) -> dict[str, Samples]:
        """Motions unlike them, by name."""
        return reach_records(self.axis.friction)

    @cached_property
    def narx_published(self) -> dict[str, NarxFit]:
        """The two NARX networks of thesis 6.2, by name."""
        return self._networks(PUBLISHED)

    @cached_property
    def narx_extended(self) -> dict[str, NarxFit]:
        """NARX networks with more data and with another regressor, by name."""
        return self._networks(EXTENDED)

    @cached_property
    def narx_linear(self) -> dict[str, NarxFit]:
        """Linear models on the same problems, by name."""
        return self._networks(LINEAR)

    @cached_property
    def contenders(self) -> list[Contender]:
        """Members of the agents' catalogue, made for the 36 circles."""
        setting = replace(self.setting, references=[*circle_references(self.setting.arm).values()])
        found = []
        with self.stage("making agents", "agents") as progress:
            names = [name for name, entry in CATALOGUE.items() if entry.is_available and not entry.takes_machine]
            for i, name in enumerate(names):
                progress(i, len(names))
                found.append(contender(name, setting))
            progress(len(names), len(names))
        return found

    @cached_property
    def all_circles(self) -> CircleStudy:
        """The 36 circles with all of them."""
        return self._circles("circles with all agents", self.robot, [each.law for each in self.contenders])

    def _learning(self, setting: AgentSetting, references: Sequence[Reference], where: str) -> dict[str, Learning]:
        n = setting.robot.n_joints
        found = {}
        for kind in (StaticBSN, ExtendedBSN):
            network = kind.zero(n)
            with self.stage(f"training {network.name}, {where}", "trials") as progress:
                found[network.name] = thesis_training(n).learn(
                    network,
                    references,
                    setting.trial,
                    watch=lambda learning, total, progress=progress: progress(learning.trials, total),  # type: ignore[misc]
                )
        return found

    def _with_networks(self, learning: dict[str, Learning], speeds: Sequence[float], where: str) -> CircleStudy:
        laws = [each.best for each in learning.values()]
        networks = self._circles(f"circles with networks of {where}", self.robot, laws, speeds)
        return self.lugre_circles.only(laws=["none", "lugre_dynamic"], speeds=speeds).join(networks)

    def _circles(
        self,
        title: str,
        robot: RobotDescription | Rig,
        laws: Sequence[FeedForwardLaw] | None = None,
        speeds: Sequence[float] = SPEEDS,
    ) -> CircleStudy:
        with self.stage(title, "s") as progress:
            n = self.n_threads
            return circle_study(robot, laws=laws, speeds=speeds, seed=SEED, n_threads=n, progress=progress)

    def _friction(self, title: str, joints: Sequence[str], numbers: Sequence[int]) -> MeasuredFriction:
        with self.stage(title, "s") as progress:
            n = self.n_threads
            return measure_friction(self.workcell, joints, numbers, seed=SEED, n_threads=n, progress=progress)

    def _networks(self, candidates: Sequence[Candidate]) -> dict[str, NarxFit]:
        found = {}
        with self.stage("NARX networks", "networks") as progress:
            for i, candidate in enumerate(candidates):
                progress(i, len(candidates))
                found[candidate.name] = fit_narx(candidate, self.narx_records | self.narx_reach, seed=SEED)
            progress(len(candidates), len(candidates))
        return found

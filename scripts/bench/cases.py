"""Cases of the benchmark: each part, and the rates and amounts that it is made of."""

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
from mujoco import batch

from ffgym.agents import LawAgent
from ffgym.agents.catalogue import CATALOGUE, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.control import CausalLaw
from ffgym.core.errors import FFGymError
from ffgym.core.provenance import is_installed
from ffgym.core.registration import find_spec
from ffgym.core.types import Array
from ffgym.effects import EFFECTS, Effect
from ffgym.envs.machines import find_machine
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.bare import bare_rate
from ffgym.simulation.plant import Machine, Plant
from ffgym.studies import circle_references, sine_references, thesis_laws
from scripts.bench.processes import collection_ratio, command_ratios, import_time, memory_of, suite
from scripts.bench.turns import Amount, Rate, Ratio, rate_of, take_turns

CIRCLES, JOINTS, ONE_AXIS = "ffgym/CirclePath-v0", "ffgym/JointMotion-v0", "ffgym/OneAxis-v0"
MANY, N_ENVS, MOST = 64, 16, 1024
"""Sub-environments of most measurements, beside other vectors and learners, and of the memory."""
SIZES = (MANY, 1, 16, 256)
"""Sub-environments that are measured against the engine."""
CELLS = "ffgym/WorkcellCircles-v0"

WANTED = {
    "stepping": 0.85,
    "workcells": 0.6,
    "real time": 10.0,
    "circles": 0.93,
    "Python of a step": 100.0,
    "memory of circles": 300.0,
}
"""What is wanted of ratios at least, of a time [us] and of memory [MiB] at most."""

# ---- the batch simulation against the bare engine: as many simulations of the same model and lengths

SPEEDS = (0.040, 0.100)
"""Circles at these speeds [m/s]; those at 10 mm/s take three quarters of the time, and show nothing else."""


def measure(arm: RigidArm, runs: list[Run], threads: int) -> tuple[float, float, float]:
    """Physics steps per second of the bare engine, of stepping alone and of all of `simulate`, one after the other."""
    lengths = np.array([(len(run.reference.t) - 1) * arm.robot.n_substeps for run in runs])
    bare = bare_rate(arm.robot, lengths, threads)
    times: list[float] = []
    began = time.perf_counter()
    simulate(runs, arm=arm, n_threads=threads, progress=lambda done, total: times.append(time.perf_counter()))
    steps = float(lengths.sum())
    return bare, steps / (times[-1] - times[0]), steps / (time.perf_counter() - began)


def simulation_ratios(robot: str, repeats: int, threads: int) -> Iterator[Ratio]:
    """Circles with three feed-forward laws: stepping (set-points, engine, states taken out), and all of it.

    All of it has the feed-forward laws before and the recordings with TCP positions after it, too.
    """
    arm = RigidArm(load_robot(robot))
    references = circle_references(arm, speeds=SPEEDS).values()
    runs = [Run(reference=reference, law=law) for reference in references for law in thesis_laws(arm.robot)]
    measure(arm, runs, threads)  # warm up: caches, and memory that later runs find in place
    bare, stepping, whole = zip(*(measure(arm, runs, threads) for _ in range(repeats)), strict=True)
    yield Ratio("simulation, stepping / bare engine", stepping, bare, "physics/s", WANTED["stepping"])
    yield Ratio("simulation, all of it / bare engine", whole, bare, "physics/s")


# ---- physics steps of machines with effects against those of the same robots without

STEPS = 400
"""Physics steps of one measurement, 0.1 s."""


def eight_effects(robot: RobotDescription) -> tuple[Effect, ...]:
    """Effects of all kinds of torque, as a diagnosis may find together; two of them have a memory."""
    sizes: dict[str, dict[str, Any]] = {
        "load_friction": {"share": 0.05},
        "asymmetry": {"coulomb": 0.1, "viscous": 0.1},
        "temperature_friction": {"viscous": 0.5, "coulomb": -0.002, "breakaway": 0.001},
        "dwell_stiction": {"share": 0.2},
        "kinematic_error": {"amplitude": 1e-4},
        "cogging": {"amplitude": 0.02},
        "torque_ripple": {"share": 0.02},
        "torsional_hysteresis": {"lost_motion": 1e-4},
    }
    return tuple(EFFECTS[name].on(robot, **values) for name, values in sizes.items())


def holding_rate(machine: Machine, copies: int, threads: int) -> Rate:
    """Function that steps copies of a machine that hold their home; returns physics steps per second of all."""
    plant, robot = Plant(machine, copies, n_threads=threads), machine.robot
    q = robot.work_area.home if robot.work_area is not None else np.zeros(robot.n_joints)
    plant.rest(np.tile(q, (copies, 1)))
    controls = np.zeros((copies, STEPS, plant.model.nu))
    plant.split_controls(controls)[0][:] = robot.drive.motor_angle(q)
    return rate_of(copies * STEPS, lambda: plant.drive(controls))


def effect_ratios(name: str, repeats: int, threads: int) -> Iterator[Ratio]:
    """Measure the share of the speed that is left with one effect and with eight, for one machine and for 36."""
    robot = load_robot(name)
    for copies in (1, 36):
        nominal = holding_rate(Machine(robot=robot), copies, threads)
        for count in (1, 8):
            worn = holding_rate(Machine(robot=robot, effects=eight_effects(robot)[:count]), copies, threads)
            title = f"{copies} machine{'s' * (copies > 1)} with {count} effect{'s' * (count > 1)} / without"
            yield take_turns(title, worn, nominal, repeats, unit="physics/s")


WORKCELLS = ("workcell:thesis", "workcell:12")
"""Workcells that are measured: one by hand, and one that is drawn."""
REAL_DRIVE = "irb4600_60_205_servo_drives"
"""Robot whose drives delay and limit torque, and read resolvers."""


def cell_ratios(repeats: int, threads: int) -> Iterator[Ratio]:
    """Measure workcells and real drives against the nominal robot, 64 and 1 of each, and one against real time."""
    nominal, real = load_robot("irb4600_60_205"), Machine(robot=load_robot(REAL_DRIVE))
    machines = {name: find_machine(name) for name in WORKCELLS} | {REAL_DRIVE: real}
    for copies in (MANY, 1):
        bare = holding_rate(Machine(robot=nominal), copies, threads)
        for name, machine in machines.items():
            wanted = WANTED["workcells"] if copies == MANY else None
            rate = holding_rate(machine, copies, threads)
            yield take_turns(f"{copies} x {name} / nominal", rate, bare, repeats, unit="physics/s", wanted=wanted)
    # environments, with all that Python does in a step
    for n in (MANY, 1):
        cells, circles = (Stepped(name, n, n_threads=threads) for name in (CELLS, CIRCLES))
        wanted = WANTED["workcells"] if n == MANY else None
        yield take_turns(f"{CELLS}, {n} / {CIRCLES}", cells.rate, circles.rate, repeats, unit="steps/s", wanted=wanted)
    # real time does not slow down with a busy machine, so that the time of the processor is what counts
    one, real_time = Stepped(CELLS, 1, n_threads=1, clock=time.process_time), 1 / nominal.servo.control_dt
    title = f"{CELLS}, one / real time"
    yield take_turns(title, one.rate, lambda: real_time, repeats, unit="steps/s", wanted=WANTED["real time"])


# ---- vector environments against the bare engine, and against Gymnasium's vectors of single environments

BLOCK = 0.15
"""Time of one measurement [s]: short enough that the next one sees the same machine, long beside the clock."""


class Stepped:
    """A vector environment that is stepped with random actions made beforehand."""

    def __init__(self, name: str, n: int, *, clock: Callable[[], float] = time.perf_counter, **arguments: Any) -> None:
        self._clock = clock
        self.env = gym.make_vec(find_spec(name), num_envs=n, **arguments)
        self.env.reset(seed=0)
        shape = (64, *(self.env.action_space.shape or ()))
        self._actions = np.random.default_rng(0).uniform(-1, 1, size=shape).astype(np.float32)
        self._n, self._steps = n, 1
        self._steps = max(1, min(len(self._actions), int(BLOCK * self.rate() / n)))

    def rate(self) -> float:
        """Steps of sub-environments per second."""
        return rate_of(self._n * self._steps, self._step, clock=self._clock)()

    def _step(self) -> None:
        for action in self._actions[: self._steps]:
            self.env.step(action)


class Bare:
    """`mujoco.batch` alone: model, threads, physics steps and states of an environment, whose robots it moves on."""

    def __init__(self, env: gym.vector.VectorEnv[Any, Any, Any]) -> None:
        self._plant = env.unwrapped.core.plant  # type: ignore[attr-defined]
        own = self._plant.batch
        self._engine = batch.Batch(self._plant.model, nsim=own.nsim, nthread=own.nthread)
        self._steps = 1
        self._steps = max(1, min(256, int(BLOCK * self.rate() / own.nsim)))

    def rate(self) -> float:
        """Control steps per second, from the environment's present state with its present set-points held."""
        self._engine.state[:] = self._plant.batch.state
        began = time.perf_counter()
        for _ in range(self._steps):
            self._engine.step(nstep=self._plant.n_substeps)
        return self._engine.nsim * self._steps / (time.perf_counter() - began)


def python_of_a_step(n: int = MANY, steps: int = 200, threads: int = 0) -> Amount:
    """Median time of a step of `n` sub-environments that is not the engine's."""
    env = Stepped(CIRCLES, n, n_threads=threads).env
    engine = env.unwrapped.core.plant.batch  # type: ignore[attr-defined]
    clock, spent, times = time.perf_counter, [0.0], []

    def timed(call: Callable[..., Any]) -> Callable[..., Any]:
        def run(*arguments: Any, **named: Any) -> Any:
            began = clock()
            out = call(*arguments, **named)
            spent[0] += clock() - began
            return out

        return run

    engine.rollout, engine.forward = timed(engine.rollout), timed(engine.forward)
    still = np.zeros(env.action_space.shape or ())
    for _ in range(steps):
        spent[0], began = 0.0, clock()
        env.step(still)
        times.append(clock() - began - spent[0])
    env.close()
    return Amount(
        f"{CIRCLES}, {n}, Python of a step", float(np.median(times)) * 1e6, "us", wanted=WANTED["Python of a step"]
    )


def against_the_engine(repeats: int, threads: int) -> Iterator[Ratio]:
    """Each environment against the bare engine; all of its steps counted, also those that begin episodes."""
    for name, n in [*((CIRCLES, n) for n in SIZES), (ONE_AXIS, MANY), (JOINTS, MANY)]:
        stepped = Stepped(name, n, n_threads=threads)
        bare, wanted = Bare(stepped.env), WANTED["circles"] if (name, n) == (CIRCLES, MANY) else None
        title = f"{name}, {n} / bare engine"
        yield take_turns(title, stepped.rate, bare.rate, repeats, unit="steps/s", wanted=wanted)
        stepped.env.close()


def against_vectors_of_single_ones(repeats: int, threads: int, n: int = N_ENVS) -> Iterator[Ratio]:
    """The native vector environment against Gymnasium's, one after the other and in a process each."""
    modes: dict[str, dict[str, Any]] = {
        "sync": {},
        "async": {"vector_kwargs": {"context": "spawn"}},  # the engine's threads do not survive a fork
    }
    for mode, arguments in modes.items():
        native = Stepped(CIRCLES, n, n_threads=threads)
        other = Stepped(CIRCLES, n, vectorization_mode=mode, **arguments)
        yield take_turns(f"{CIRCLES}, {n} / {mode} vector", native.rate, other.rate, repeats, unit="steps/s")
        native.env.close()
        other.env.close()


def beginnings(threads: int, n: int = MANY) -> Iterator[Amount]:
    """Time that one sub-environment needs to begin an episode: at first, and with the motion known."""
    for name in (CIRCLES, JOINTS):
        env = gym.make_vec(find_spec(name), num_envs=n, n_threads=threads)
        times = []
        for seed in range(6):
            began = time.perf_counter()
            env.reset(seed=seed)
            times.append((time.perf_counter() - began) / n * 1e3)
        yield Amount(f"{name}, reset of one of {n}, the first", times[0], "ms")
        yield Amount(f"{name}, reset of one of {n}, later", float(np.median(times[1:])), "ms")
        env.close()


# ---- what a decision of each agent costs, against a step of the environment it decides for

FREQUENCY = 1.0
"""Frequency of the sine [Hz] on one axis, on which learning families are trained in seconds; long enough for the
decisions that are timed. The law of a robot costs as much, but for its joints."""
DECISIONS = 100
"""In one measurement: they take 0.01 s to 0.1 s."""


def decision_ratios(sizes: Sequence[int], repeats: int) -> Iterator[Ratio]:
    """Decisions per second of every agent that one axis has a use for, against steps per second of the environment."""
    robot = load_robot("one_axis")
    setting = AgentSetting.of(robot, references=[sine_references(robot)[FREQUENCY]])
    for name, entry in CATALOGUE.items():
        if name == "none" or entry.needs_arm:
            continue
        try:
            law = make_law(name, setting)
        except FFGymError as error:  # a library that this installation lacks
            print(f"{name}: left out: {error}")
            continue
        assert isinstance(law, CausalLaw)  # all but `none` are
        for size in sizes:
            env = gym.make_vec(find_spec(ONE_AXIS), num_envs=size, frequencies=[FREQUENCY], preview=law.preview)
            still = np.zeros(env.action_space.shape or ())
            agent, (observation, _) = LawAgent.for_env(law, env), env.reset(seed=0)
            observations = [observation, *(env.step(still)[0] for _ in range(DECISIONS - 1))]

            def decide(agent: LawAgent = agent, observations: list[Any] = observations) -> None:
                memory = None
                for seen in observations:
                    _, memory = agent.predict(seen, memory)

            def step(env: Any = env, still: Array = still) -> None:
                for _ in range(DECISIONS):
                    env.step(still)

            rates = rate_of(DECISIONS, decide), rate_of(DECISIONS, step, before=partial(env.reset, seed=0))
            title = f"{law.name} / environment, {size} robot{'s' if size > 1 else ''}"
            yield take_turns(title, *rates, repeats, unit="steps/s")
            env.close()


# ---- PPO of stable-baselines3 on the native vector environment, against SB3's own vector of single environments

NETWORK = (64, 64)
"""Layers of the policy."""
PPO_SETTINGS: dict[str, Any] = {"n_steps": 64, "batch_size": 256, "n_epochs": 4}
"""A small network learns from 1024 steps at a time, so that one measurement takes a second."""


def training_ratios(repeats: int) -> Iterator[Ratio]:
    """Steps per second of `learn`, on one thread of torch; none if stable-baselines3 is not installed."""
    if not (is_installed("stable-baselines3") and is_installed("torch")):
        print("training: left out, needs stable-baselines3; pip install 'ffgym[rl]'")
        return
    import torch
    from stable_baselines3.common.env_util import make_vec_env

    from ffgym.envs import make_sb3_env

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        native, single = make_sb3_env(CIRCLES, N_ENVS), make_vec_env(CIRCLES, N_ENVS)
        rates = learning_rate_of(native), learning_rate_of(single)
        yield take_turns(f"PPO, {N_ENVS} envs: ffgym.envs.sb3 / DummyVecEnv", *rates, repeats, unit="steps/s")
        native.close()
        single.close()
    finally:
        torch.set_num_threads(threads)


def learning_rate_of(env: Any) -> Rate:
    """Function that lets PPO learn for one batch of steps and returns steps of sub-environments per second."""
    from stable_baselines3 import PPO

    model = PPO("MlpPolicy", env, seed=0, device="cpu", policy_kwargs={"net_arch": list(NETWORK)}, **PPO_SETTINGS)
    steps = PPO_SETTINGS["n_steps"] * env.num_envs
    return rate_of(steps, lambda: model.learn(steps, reset_num_timesteps=False))


def parts(robot: str, repeats: int, long_repeats: int, threads: int) -> dict[str, list[Callable[[], Any]]]:
    """Measurements of each part by its name; each returns one result or several."""
    return {
        "simulation": [partial(simulation_ratios, robot, long_repeats, threads)],
        "effects": [partial(effect_ratios, robot, repeats, threads), partial(cell_ratios, repeats, threads)],
        "environments": [
            partial(against_the_engine, repeats, threads),
            lambda: [python_of_a_step(threads=threads)],
            partial(beginnings, threads),
        ],
        "vectors": [partial(against_vectors_of_single_ones, repeats, threads)],
        "agents": [partial(decision_ratios, (1, MANY), long_repeats)],
        "training": [partial(training_ratios, long_repeats)],
        "memory": [
            lambda: [memory_of(CIRCLES, MOST, wanted=WANTED["memory of circles"])],
            lambda: [memory_of(JOINTS, MOST)],
            lambda: [import_time(5)],
        ],
        "commands": [partial(command_ratios, long_repeats), partial(collection_ratio, 1)],
        "tests": [suite],
    }

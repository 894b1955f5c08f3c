"""Programs of trials, and logs of a machine that follows them with errors that a test sets; nothing is simulated."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ffgym.deployment.trial import TrialPlan, TrialProgram, plan_trial
from ffgym.deployment.trial.matching import TrialLog
from ffgym.recordings import Header, Phase, Recording

DT, REST, MOVE = 0.004, 0.3, 1.2
"""Sample time, rest at either end, and time in motion of the programs [s]."""
HEADER = Header(robot="two_joints", joints=("j1", "j2"), gear_ratio=(100.0, -80.0), position_side="motor")


def make_path(t: np.ndarray, middle: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Joint positions (T, 2) [rad] and tool (T, 3) [m] on a way out and back, at rest before and after it."""
    share = np.clip((t - REST) * speed / MOVE, 0.0, 1.0)
    s = 0.5 - 0.5 * np.cos(2 * np.pi * share)
    joints = np.stack([middle + 0.02 * s, 0.01 * np.sin(2 * np.pi * s) - middle], axis=1)
    tool = np.stack([0.05 * s, 0.02 * s**2, np.full_like(s, middle)], axis=1)
    return joints, tool


def make_program(name: str = "line", middle: float = 0.5, speed: float = 1.0) -> TrialProgram:
    """Program of two joints."""
    end = REST + MOVE / speed
    t = np.arange(round((end + REST) / DT) + 1) * DT
    joints, tool = make_path(t, middle, speed)
    columns = {"timestamp": t}
    for j, joint in enumerate(HEADER.joints):
        motor = HEADER.gear_ratio[j] * joints[:, j]
        for family, values in (
            ("reference.position", motor),
            ("reference.velocity", np.gradient(motor, DT)),
            ("reference.acceleration", np.gradient(np.gradient(motor, DT), DT)),
        ):
            columns[f"{family}.{joint}"] = values
    columns |= {f"tcp_reference.position.{axis}": tool[:, k] for k, axis in enumerate("xyz")}
    phases = (
        Phase(label="rest", kind="standstill", start=0.0, end=REST),
        Phase(label="way", kind="motion", start=REST, end=end),
        Phase(label="rest", kind="standstill", start=end, end=float(t[-1]) + DT),
    )
    return TrialProgram(recording=Recording(columns, replace(HEADER, segment=name, phases=phases)))


def make_plan(*programs: TrialProgram, pairs: int = 6, seed: int = 1, warm_up: int = 1, laps: int = 1) -> TrialPlan:
    """Plan of the given programs, or of one."""
    return plan_trial("two_joints", programs or [make_program()], pairs=pairs, seed=seed, warm_up=warm_up, laps=laps)


@dataclass(frozen=True, kw_only=True)
class Machine:
    """Machine that errs across its path, by a size [m] with and without the correction, and lags by 5 ms."""

    without: float = 1e-4
    corrected: float = 6e-5
    scatter: float = 0.02
    """Relative standard deviation of the errors from run to run."""
    noise: float = 5e-6
    """Of the tracker [m]; zero is a machine without one."""
    commands: bool = True
    """True if logs hold the commanded positions, in which the correction is seen."""
    dt: float = 0.004
    lag: float = 0.005
    wait: float = 0.5
    """Time from the begin of a log to that of its program [s]."""

    def run(
        self, program: TrialProgram, corrected: bool, *, rng: np.random.Generator, begin: float = 0.0, laps: int = 1
    ) -> Recording:
        """Log of one run, on a clock that shows `begin` [s] when it begins."""
        span = program.duration
        t = np.arange(round((laps * span + 1.0) / self.dt)) * self.dt
        within = np.where((t > self.wait) & (t < self.wait + laps * span), (t - self.wait) % span, 0.0)
        size = (self.corrected if corrected else self.without) * np.exp(self.scatter * rng.standard_normal())
        own = program.recording
        joints = {joint: np.interp(within, own.t, program.joints[:, j]) for j, joint in enumerate(HEADER.joints)}
        late = np.maximum(within - self.lag, 0.0)
        bump = np.sin(np.pi * np.clip((late - REST) / (span - 2 * REST), 0, 1)) ** 2
        columns = {"timestamp": begin + t}
        for j, joint in enumerate(HEADER.joints):
            ratio = HEADER.gear_ratio[j]
            columns[f"motor.position.{joint}"] = ratio * (np.interp(late, own.t, program.joints[:, j]) + size * bump)
            if self.commands:
                columns[f"reference.position.{joint}"] = ratio * (joints[joint] + 2e-4 * corrected * bump)
        if self.noise:
            tool = program.tool_path(late)
            tool[:, 2] += np.sqrt(8 / 3) * size * bump
            tool += self.noise * rng.standard_normal(tool.shape)
            columns |= {f"tcp.position.{axis}": tool[:, k] for k, axis in enumerate("xyz")}
        return Recording(columns, replace(HEADER, segment="log"))

    def carry_out(
        self, plan: TrialPlan, seed: int = 0, *, switch: Callable[[int, bool], bool] = lambda number, on: on
    ) -> list[TrialLog]:
        """Logs of all runs of a plan, on one clock; `switch` tells what the operator really switched."""
        rng = np.random.default_rng(seed)
        return [
            TrialLog(
                run.log,
                self.run(
                    plan.program(run.program),
                    switch(run.number, run.corrected),
                    rng=rng,
                    begin=20.0 * run.number,
                    laps=plan.laps,
                ),
            )
            for run in plan.runs
        ]

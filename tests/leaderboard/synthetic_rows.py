"""Rows as a leaderboard has them, with errors of realistic size made from a formula and a seed."""

import hashlib
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from ffgym.control import SetpointResponse
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL, draw_name
from ffgym.leaderboard.presentation.page import ToolTrace
from ffgym.leaderboard.results import CircleResult, Outcome, Row, SentSetpoints

POSITIONS = ("p1", "p2", "p3", "p4")
SPEEDS = (10.0, 40.0, 100.0)
RADII = (1.0, 3.0, 5.0)
LEVEL_UM = {10.0: 85.0, 20.0: 130.0, 40.0: 230.0, 70.0: 390.0, 100.0: 640.0}
"""Error with zero action by speed [mm/s]."""


@dataclass(frozen=True)
class Sort:
    """What an invented agent leaves of the error at 10, 40 and 100 mm/s."""

    title: str
    left: tuple[float, float, float]
    track: str = "causal, nominal parameters"
    base: str | None = None
    spread: float = 0.0
    seconds: float = 0.0
    steps: int = 0
    us: float | None = None
    ranked: bool = True
    setpoints: SentSetpoints | None = None


SORTS = {
    "none": Sort("no compensation", (1.0, 1.0, 1.0), track="causal", ranked=False),
    "random": Sort("random actions", (1.9, 1.4, 1.15), track="causal", spread=0.05, us=9.0, ranked=False),
    "lugre_static": Sort("static LuGre", (0.62, 0.8, 0.99)),
    "lugre_dynamic": Sort("dynamic LuGre", (0.41, 0.72, 0.98)),
    "bsn_static": Sort("static B-spline network", (0.63, 0.77, 0.97), track="causal", seconds=812.0),
    "bsn_extended": Sort("extended B-spline network", (0.57, 0.75, 0.96), track="causal", seconds=812.0),
    "bsn_extended_prior": Sort(
        "extended B-spline network with prior", (0.44, 0.7, 0.95), track="causal", seconds=790.0
    ),
    "mlp_fel": Sort("perceptron, feedback-error learning", (0.5, 0.74, 0.94), spread=0.03, seconds=1630.0),
    "narx": Sort(
        "NARX network", (0.55, 0.78, 0.99), track="causal", seconds=420.0,
        setpoints=SentSetpoints(response=SetpointResponse(delay=0.008)),
    ),
    "residual_gp": Sort("residual torque model", (0.36, 0.69, 0.93), track="causal", seconds=420.0),
    "ilc_motor": Sort("iterative learning on motor positions", (0.25, 0.55, 0.9), track="per task", seconds=2105.0),
    "ilc_tcp": Sort("iterative learning on the tool's position", (0.11, 0.12, 0.13), track="per task", seconds=2105.0),
    "elastic": Sort("elastic feed-forward", (0.35, 0.26, 0.21)),
    "sac_lugre": Sort(
        "SAC on dynamic LuGre", (0.37, 0.63, 0.8), base="lugre_dynamic", spread=0.03, steps=2_000_000, us=160.0
    ),
    "ppo_elastic": Sort(
        "PPO on elastic feed-forward", (0.35, 0.255, 0.212), base="elastic", spread=0.05, steps=10_000_000, us=155.0
    ),
    "tqc_elastic": Sort(
        "TQC on elastic feed-forward", (0.29, 0.2, 0.16), base="elastic", spread=0.04, steps=2_000_000, us=171.0
    ),
    "online_gp": Sort(
        "SAC on the residual torque model", (0.42, 0.75, 0.99), track="causal", base="residual_gp", spread=0.04,
        steps=1_000_000, us=158.0,
    ),
    "oracle": Sort("elastic feed-forward with the true parameters", (0.06, 0.07, 0.08), track="oracle", ranked=False),
}  # fmt: skip


def keys() -> list[tuple[str, str, float, float]]:
    """All circles: split, position, radius [mm], speed [mm/s]."""
    own = [("train", "p1", r, v) for v in SPEEDS for r in RADII]
    others = [("positions", p, r, v) for v in SPEEDS for p in POSITIONS[1:] for r in RADII]
    radii = [("radii", "p1", r, v) for v in SPEEDS for r in (2.0, 4.0)]
    return own + others + radii + [("speeds", "p1", r, v) for v in (20.0, 70.0) for r in RADII]


def left(sort: Sort, speed: float) -> float:
    """What an agent leaves at a speed: straight lines over the logarithm of the speed."""
    return float(np.interp(np.log(speed), np.log(SPEEDS), sort.left))


def outcome(name: str, seed: int, plant: str) -> Outcome:
    """One agent with one seed on one plant: noise of its own on an error that plant and circle set."""
    sort = SORTS[name]
    of_plant = np.random.default_rng(crc32(plant.encode()))
    own = np.random.default_rng([crc32(name.encode()), seed, crc32(plant.encode())])
    trained = 1 + sort.spread * np.random.default_rng([crc32(name.encode()), seed]).normal()
    mismatch = 1.0 if plant == NOMINAL or sort.track == "per task" else 1.25
    cells = []
    for split, position, radius, speed in keys():
        zero = LEVEL_UM[speed] * (1.15 - 0.05 * radius) * float(np.exp(0.12 * of_plant.normal())) * 1e-3
        share = 1.0 if name == "none" else min(left(sort, speed) * mismatch, max(left(sort, speed), 1.03)) * trained
        rms = zero * share * (1.0 if name == "none" else float(np.exp(0.06 * own.normal())))
        motor = tuple((rms * 1e-2 * np.array([4.1, 3.3, 3.9, 6.0, 5.2, 7.4]) * own.uniform(0.8, 1.2, 6)).tolist())
        cells.append(
            CircleResult(
                split=split, position=position, radius_mm=radius, speed_mm_s=speed, rms_mm=rms, max_mm=2.3 * rms,
                rms_3d_mm=1.2 * rms, max_3d_mm=2.9 * rms, motor_rms_rad=motor,
            )
        )  # fmt: skip
    artefact = hashlib.sha256(f"{name} {seed}".encode()).hexdigest() if sort.seconds or sort.steps else None
    return Outcome(
        seed=seed, plant=plant, fingerprint=hashlib.sha256(plant.encode()).hexdigest()[:16], artefact=artefact,
        versions="ffgym 0.0.test",
        robot_seconds=sort.seconds, env_steps=sort.steps, inference_us=sort.us, cells=tuple(cells),
    )  # fmt: skip


def row(name: str, plants: list[str], seeds: int = 5) -> Row:
    """One row; agents that a seed changes have several."""
    sort = SORTS[name]
    seeded = sort.spread > 0
    curve = [(float(k), -0.4 * float(np.exp(-k / 4e5)) - 0.12) for k in range(0, sort.steps + 1, 100_000)]
    return Row(
        name=name,
        title=sort.title,
        track=sort.track,
        about=f"Invented for tests: what {sort.title} might leave of the error.",
        page="lugre.md" if name.startswith("lugre") else None,
        base=sort.base,
        setpoints=sort.setpoints,
        seeded=seeded,
        command=f"ffgym train {name} --seeds {seeds}" if sort.seconds or sort.steps else None,
        ranked=sort.ranked,
        outcomes=tuple(outcome(name, seed, plant) for seed in range(seeds if seeded else 1) for plant in plants),
        learning_curve=tuple(curve) if sort.steps else (),
        feedback=sort.base is not None,
    )


def plants(draws: int) -> list[str]:
    """Nominal robot, workcell, drawn ones."""
    return [NOMINAL, THESIS_WORKCELL, *(draw_name(k) for k in range(draws))]


def rows(draws: int = 20, seeds: int = 5) -> list[Row]:
    """All rows; the oracle does not know the workcell."""
    every = plants(draws)
    known = [plant for plant in every if plant != THESIS_WORKCELL]
    return [row(name, known if name == "oracle" else every, seeds) for name in SORTS]


def tracks() -> dict[str, dict[float, ToolTrace]]:
    """Paths of the tool on one circle of 3 mm at 10, 40 and 100 mm/s."""
    return {name: {speed: _path(sort, speed) for speed in SPEEDS} for name, sort in SORTS.items() if name != "random"}


def _path(sort: Sort, speed: float) -> ToolTrace:
    angle = np.linspace(0, 2 * np.pi, 400)
    size = left(sort, speed) * LEVEL_UM[speed] * 1e-3
    outward = size * (0.5 * np.cos(2 * angle + 0.4) + np.exp(-(((angle - 2.0) / 0.2) ** 2)) - 0.4)
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return ToolTrace(reference=3.0 * unit, tool=(3.0 + outward)[:, None] * unit, where="p2, r = 3 mm, invented")

"""What docs/performance.md tells of the sizes of the benchmark, and of what is wanted."""

from collections.abc import Iterator

from ffgym.robot import load_robot
from scripts.bench.cases import MANY, MOST, N_ENVS, NETWORK, SIZES, WANTED
from scripts.bench.processes import IMPORT, STEPS
from scripts.bench.turns import WIDE
from scripts.claims.claim import claim
from scripts.claims.told.constants import CODE


@claim(CODE)
def what_is_a_wide_ratio() -> Iterator[str]:
    """Distance of quartiles that is called wide."""
    yield f"where they are more than {100 * WIDE:g} % apart"


@claim(CODE)
def what_is_benchmarked() -> Iterator[str]:
    """Sizes of what is measured, and what is wanted."""
    dt = load_robot("irb4600_60_205").servo.control_dt
    layers = " x ".join(map(str, NETWORK))
    yield f"as many simulations of the same lengths | stepping {WANTED['stepping']:g} |"
    yield f"| {MANY} [workcells](workcell.md) of one kind and {MANY} robots with real drives; "
    yield f"`WorkcellCircles` of {MANY} |"
    yield f"| the nominal robot; `CirclePath` of {MANY} | {WANTED['workcells']:g} |"
    yield f"real time, {1 / dt:.0f} steps of {1e3 * dt:g} ms a second | {WANTED['real time']:g} on a quiet host |"
    yield f"| vector environment, {min(SIZES)} to {max(SIZES)} sub-environments, random actions |"
    yield f"and nothing else | {WANTED['circles']:g} at {MANY} circles |"
    yield f"| Python of a step of {MANY}: its time without calls of the engine | | {WANTED['Python of a step']:g} us |"
    yield f"| native vector environment, {N_ENVS} sub-environments |"
    yield f"on one axis, for 1 and {MANY} robots |"
    yield f"| PPO's `learn`, {N_ENVS} environments, {layers} network,"
    yield (
        f"| memory of {MOST} sub-environments beyond the import, made, reset and stepped {STEPS} times | | "
        f"{WANTED['memory of circles']:g} MiB for circles |"
    )
    yield f"| `import ffgym` in a fresh process | | {IMPORT:g} s |"

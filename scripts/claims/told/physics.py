"""What docs/physics.md tells of its made tables, and of the code."""

from collections.abc import Iterator
from inspect import signature

import numpy as np

from ffgym.robot import RigidArm, builtin_robots, load_robot, resonances, solve_path
from scripts.claims.claim import claim
from scripts.claims.made import table_of
from scripts.tables.physics import BENT, FREQUENCY, TORQUE, energy_drift

AGAIN = "python -m scripts.tables --page physics.md"


@claim("ffgym.robot.load_robot")
def steps_of_physics() -> Iterator[str]:
    """Physics step of all robots that ship."""
    (step,) = {load_robot(name).physics_dt for name in builtin_robots()}
    yield f"`simulation.physics_dt` ({1e3 * step:g} ms for the built-in robots)"


@claim(AGAIN)
def torque_of_lugre_table() -> Iterator[str]:
    """Torque that the LuGre table is made with."""
    yield f"a sinusoidal torque of {TORQUE:g} N m at {FREQUENCY:g} Hz"


@claim("2 pi / 2^bits / period")
def steps_of_resolver_speed() -> Iterator[str]:
    """Steps in which a speed comes from a resolver."""
    bits, period = 16, 5e-4
    yield f"{2 * np.pi / 2**bits / period:.2f} rad/s at {bits} bits and {1e3 * period:g} ms"


@claim(AGAIN)
def start_of_energy_table() -> Iterator[str]:
    """Deflection and duration of the energy table, and the step at which it becomes unstable."""
    duration = signature(energy_drift).parameters["duration"].default
    yield f"with every spring bent by {1e3 * BENT:g} mrad; it swings and falls for {duration:g} s."
    robot = load_robot("irb4600_60_205")
    area = robot.work_area
    assert area is not None
    arm = RigidArm(robot)
    home = solve_path(arm, next(iter(area.positions.values()))[None], area.tool_rotation, area.home)[0]
    fastest = float(resonances(arm, home).max())
    yield (
        f"unstable at steps above about {1e3 / (np.pi * fastest):.0f} ms, twice the inverse angular frequency of its "
        f"fastest mode ({fastest:.0f} Hz)"
    )


@claim(AGAIN)
def circles_at_half_the_step() -> Iterator[str]:
    """Largest changes of the circle study at half the step."""
    rows = table_of("docs/physics.md", "circles")
    paths = {name: row for name, row in rows.items() if name.endswith("_mm")}
    worst = max(float(row["worst change [%]"]) for row in paths.values())
    size = max(float(row["largest change"].removesuffix(" µm")) for row in paths.values())
    yield f"Path errors change by at most {worst:.1f} %, and by {size:.0f} µm."
    tiny = [rows[f"{speed}, motor_rms_rad"] for speed in (10, 40)]
    assert all(row["worst law"] == "lugre_dynamic" for row in tiny)
    most, angle = (
        max(float(row[name].removesuffix(" mrad")) for row in tiny) for name in ("worst change [%]", "largest change")
    )
    bits = load_robot("irb4600_60_205").sensors.encoder_bits
    yield (
        f"Motor errors change by up to {most:g} % where they are tiny, under perfect dynamic compensation at 10 and 40 "
        f"mm/s: by {angle:g} mrad at most, little more than one step of the {bits} bit resolver "
        f"({2e3 * np.pi / 2**bits:.3f} mrad)"
    )

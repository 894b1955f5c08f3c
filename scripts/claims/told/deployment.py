"""What docs/deployment/code.md and docs/deployment/programs.md tell of the code, and of a stored record."""

import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ffgym.agents.artefacts import TRAINED
from ffgym.agents.bspline import ExtendedBSN
from ffgym.agents.elastic import elastic_law
from ffgym.agents.law_files import load_law
from ffgym.agents.model import model_law
from ffgym.agents.spline_basis import SplineBasis
from ffgym.control import CausalLaw, DynamicLuGreExact, FeedForwardLaw, StaticLuGre, Window
from ffgym.deployment.code import fmu_check, law, policy
from ffgym.deployment.code.table import LawTable, write_table
from ffgym.deployment.programs import points, rapid
from ffgym.paths import load_motion
from ffgym.robot import RigidArm, load_robot
from scripts.claims.claim import claim
from scripts.claims.page import ROOT
from scripts.claims.records import numbers_of

CODE = "the code itself"


@claim(CODE)
def tolerances_of_code() -> Iterator[str]:
    """Tolerances of what is written for machines without Python."""
    yield f"every torque along the motion, {law.TOLERANCE:.0e} of the largest one".replace("e-0", "e-")
    yield f"every torque of the policy in closed loop, {policy.TOLERANCE:.0e} of its largest one".replace("e-0", "e-")
    yield f"at every control step, {fmu_check.TOLERANCE:.0e} in SI units".replace("e-0", "e-")


@claim(CODE)
def memory_of_laws_in_c() -> Iterator[str]:
    """Numbers that laws keep from sample to sample."""
    robot = load_robot("irb4600_60_205")
    arm = RigidArm(robot)
    reference = load_motion(arm, "circles").reference
    both = replace(robot, friction=replace(robot.friction, arm_share=np.full(robot.n_joints, 0.5)))
    basis, dynamic = SplineBasis(), DynamicLuGreExact(robot.friction)
    splines = ExtendedBSN(coefficients=np.zeros((robot.n_joints, 2, basis.n_splines)), basis=basis)
    laws: dict[str, FeedForwardLaw] = {
        "static LuGre": StaticLuGre(robot.friction),
        f"dynamic LuGre, {dynamic.n_substeps} sub-steps": dynamic,
        "elastic feed-forward": elastic_law(arm),
        "elastic feed-forward, friction on motors and arm": elastic_law(RigidArm(both)),
        "feed-forward from a machine with backlash": model_law(ROOT / "docs" / "backlash.toml", arm),
        "B-spline networks: static, extended, over speed and position": splines,
        "NARX network": load_law(TRAINED / "narx" / "nominal" / "seed_0.npz"),
        "network of feedback error learning": load_law(TRAINED / "mlp_fel" / "nominal" / "seed_0.npz"),
        "Gaussian process of the residual torque": load_law(TRAINED / "residual_gp" / "nominal" / "seed_0.npz"),
    }
    for name, each in laws.items():
        assert isinstance(each, CausalLaw)
        memory = each.initial_memory(Window.along(reference, each.preview)[0])
        yield f"| {name} | {len(memory)} |"


@claim(CODE)
def bytes_of_tables() -> Iterator[str]:
    """Places in a binary table."""
    dt, names = 0.125, ("first [1]", "second [1]")
    values = {name: np.zeros((5, 3)) for name in names}
    with TemporaryDirectory() as folder:
        write_table(LawTable(joints=("a", "b", "c"), dt=dt, values=values), Path(folder) / "table")
        data = (Path(folder) / "table" / "table.bin").read_bytes()
    first, second = (data.index(name.encode()) for name in names)
    yield f"| {data.index(b'FFGYMTB1')} | `FFGYMTB1` |"
    yield f"| {data.index(struct.pack('<I', 1))} | `unsigned int`:"
    yield f"| {data.index(struct.pack('<3I', 3, 2, 5))} | likewise: joints N, quantities Q, samples T |"
    yield f"| {data.index(struct.pack('<d', dt))} | time between samples [s] |"
    yield f"| {first} | names with their units, zero-terminated, {second - first} bytes for each of Q |"


@claim(CODE)
def formats_of_programs() -> Iterator[str]:
    """Length of procedures."""
    yield f"procedures of {rapid.MOVES_IN_PROCEDURE} moves"


@claim(CODE)
def points_of_programs() -> Iterator[str]:
    """Settings of points and zones."""
    yield f"`--tolerance-mm` ({1e3 * points.TOLERANCE:g}) is the largest distance"
    yield f"may use {100 * points._SHARE:g} % of it; the rest"
    yield f"may also be {1e3 * points._TIMING:g} ms ahead of the plan or behind at most, and lasts"
    yield f"lasts {points._LONGEST:g} s at most"
    yield f"have zones of {1e3 * points.ZONE:g} mm, which"


@claim("python -m scripts.claims --record corrected_program")
def what_a_program_loses() -> Iterator[str]:
    """Distances of the tool from the path without a correction, with set-points, and with a corrected program."""
    record = numbers_of("corrected_program")
    for name, way in record["ways"].items():
        yield f"| {name} | {way['duration_s']:.1f} s | {way['rms_um']:.0f} um | {way['largest_um']:.0f} um |"
    yield f"The path that was read back is {record['from_plan_mm']:.3f} mm from the plan"

"""What the simulation gets wrong about the published robot: docs/published_robot.md, from docs/published_robot.json.

Structures and their fits come from the file; headlines of each class of model, and lost motion on a slow triangle, are
simulated (three minutes).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ffgym.agents import dynamic_lugre
from ffgym.agents.elastic import elastic_feedforward, elastic_law
from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.core.files import read_text
from ffgym.core.types import Array
from ffgym.diagnosis.tables.parts import find_structure
from ffgym.diagnosis.tables.structures import CandidateModel
from ffgym.effects import NativeEffect
from ffgym.paths import load_motion
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import Run, SimulatedRig, simulate
from ffgym.simulation.plant import Machine
from ffgym.studies import circle_study
from scripts.tables.page import DOCS, Contents, markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESULT = DOCS / "published_robot.json"
TRIANGLE = DOCS / "slow_triangle.toml"
"""Motion that separates the structures."""

CLASSES = ("numbers", "arm_friction", "backlash")
"""Structures whose machines the headlines are told for: all losses before the spring, friction behind it, a gap."""

SPEEDS = (0.010, 0.040, 0.100)


def published_robot(speeds: Sequence[float] = SPEEDS, positions: Sequence[str] | None = None) -> Contents:
    """Make tables and pictures of the page."""
    result = json.loads(read_text(RESULT))
    robot = load_robot(result["table"]["robot"])
    known = {each["name"]: each for each in result["structures"]}
    chosen = {name: fitted_machine(robot, known[name]) for name in CLASSES if name in known}
    return Contents(
        parts={
            "structures": describe_structures(result),
            "signs": describe_signs(result),
            "headlines": _headlines(chosen, speeds, positions),
        },
        numbers={"verdict": result["verdict"], "structures": [each["name"] for each in result["structures"]]},
        pictures={
            "published_robot": _draw_structures(result),
            "published_robot_triangle": _draw_triangle(chosen),
        },
    )


def fitted_machine(robot: RobotDescription, structure: Mapping[str, Any]) -> Machine:
    """Build the machine of a structure from its fitted numbers, with a servo that its controller knows."""
    found = structure_candidate(robot, structure)
    beside = tuple(effect for effect in found.effects if not isinstance(effect, NativeEffect))
    return Machine(robot=found.machine.physical, effects=beside)


def structure_candidate(robot: RobotDescription, structure: Mapping[str, Any]) -> CandidateModel:
    """Build the candidate of a structure from its fitted numbers, as the result file has them."""
    values = {number["name"]: number["value"] for number in structure["numbers"]}
    return find_structure(structure["name"]).candidate_with(robot, values)


def describe_structures(result: Mapping[str, Any]) -> str:
    """Table of all structures, the best first."""
    first = result["structures"][0]
    head = [
        "structure",
        "free numbers",
        f"fitted, of {first['fitted_rms']}",
        f"held out, of {first['held_out_rms']}",
        f"position left out, of {first['fitted_rms']}",
        f"sign right, of {first['sign_cells']}",
        "score on unseen rows",
        "behind the best, 90 %",
    ]
    rows = [
        (
            each["title"],
            f"{each['free_parameters']}",
            f"{each['fitted_within_1_5']}",
            f"{each['held_out_within_1_5']}",
            f"{each['left_out_within_1_5']}" + ("" if each["left_out_by"] == "refit" else " (one step)"),
            f"{each['sign_right']}",
            f"{each['score']:.3f}",
            "tie" if each["is_tied"] else f"{each['behind_low']:.3f} to {each['behind_high']:.3f}",
        )
        for each in result["structures"]
    ]
    return markdown(head, rows)


def describe_signs(result: Mapping[str, Any]) -> str:
    """Table of both facts: RMS with dynamic LuGre over none at 40 mm/s, r = 1 mm, and RMS with it at 10 mm/s."""
    rows = [("published", *(f"{x:.2f}" for x in result["structures"][0]["sign_measured"]), *_slow(result, None))]
    for each in result["structures"]:
        ratios = [f"{x:.2f}" for x in each["sign_ratios"]]
        rows.append((each["title"], *ratios, *_slow(result, each["predicted_mm"])))
    places = [row["position"] for row in result["rows"] if _asked(row, "lugre_dynamic", 40.0) and row["radius_mm"] == 1]
    return markdown(["structure", *places, "r = 1 mm", "3 mm", "5 mm"], rows)


def _slow(result: Mapping[str, Any], predicted: Sequence[float] | None) -> list[str]:
    """Mean RMS error with dynamic LuGre at 10 mm/s over the positions, by radius [mm]."""
    found = []
    for radius in (1.0, 3.0, 5.0):
        rows = [
            i
            for i, row in enumerate(result["rows"])
            if _asked(row, "lugre_dynamic", 10.0) and row["radius_mm"] == radius
        ]
        values = [result["rows"][i]["value_mm"] if predicted is None else predicted[i] for i in rows]
        found.append(f"{np.mean(values):.3f}")
    return found


def _asked(row: Mapping[str, Any], law: str, speed_mm_s: float) -> bool:
    return (row["law"], row["statistic"], row["speed_mm_s"]) == (law, "rms", speed_mm_s)


def _headlines(machines: Mapping[str, Machine], speeds: Sequence[float], positions: Sequence[str] | None) -> str:
    """Table of what each law leaves on machines of each class: mean RMS path error over the circles [mm]."""
    rows = []
    for name, machine in machines.items():
        described = machine.robot
        laws: dict[str, FeedForwardLaw] = {
            "none": NoCompensation(),
            "dynamic LuGre": dynamic_lugre(described),
            "elastic, all friction on the motor": replace(
                elastic_feedforward(described.with_arm_share(None)), name="blind"
            ),
        }
        if described.friction.arm_share is not None:
            laws["elastic that knows the share"] = elastic_law(RigidArm(described), name="knowing")
        rig = SimulatedRig(arm=RigidArm(described), machine=machine)
        study = circle_study(rig, laws=[*laws.values()], speeds=speeds, positions=positions)
        for title, law in laws.items():
            cells = [study.select(agent=law.name, speed_mm_s=round(v * 1e3, 6)) for v in speeds]
            errors = [float(np.mean([cell.rms_mm for cell in each])) for each in cells]
            rows.append((find_structure(name).title, title, *(f"{error:.3f}" for error in errors)))
    return markdown(["machine", "law", *(f"{v * 1e3:g} mm/s" for v in speeds)], rows)


def _draw_structures(result: Mapping[str, Any]) -> "Figure":
    """Draw what each structure explains: fitted and held-out rows, and the sign."""
    from matplotlib.figure import Figure

    structures = result["structures"][::-1]
    figure = Figure(figsize=(9.5, 0.34 * len(structures) + 1.8), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[5, 4])
    y = np.arange(len(structures))
    for key, total, colour, marker, label in (
        ("fitted_within_1_5", "fitted_rms", "#4C72B0", "o", "fitted (Tables 4.1, 4.2)"),
        ("held_out_within_1_5", "held_out_rms", "#C44E52", "s", "held out (Tables 5.1, 5.2)"),
    ):
        shares = [100 * each[key] / each[total] for each in structures]
        left.plot(shares, y, marker, color=colour, label=label)
    left.set_yticks(y, [f"{each['title']} ({each['free_parameters']})" for each in structures], fontsize=8)
    left.set_xlabel("RMS errors within a factor 1.5 [%]")
    left.legend(loc="lower left", bbox_to_anchor=(0, 1), fontsize=8)
    measured = structures[0]["sign_measured"]
    right.axvspan(min(measured), max(measured), color="#55A868", alpha=0.25, label="published, four positions")
    right.axvline(1.0, color="black", linewidth=0.8)
    for k, each in enumerate(structures):
        right.plot(each["sign_ratios"], [k] * len(each["sign_ratios"]), "|", color="#4C72B0", markersize=11)
    right.set_xlabel("RMS with LuGre / without,\n40 mm/s, r = 1 mm")
    right.legend(loc="lower left", bbox_to_anchor=(0, 1), fontsize=8)
    for axes in (left, right):
        axes.grid(axis="x", alpha=0.3)
    return figure


def _draw_triangle(machines: Mapping[str, Machine]) -> "Figure":
    """Draw the lost motion of each class on the slow triangle: the tool beside where the motors put it."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.2), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(machines), sharey=True))
    for axes, (name, machine) in zip(panels, machines.items(), strict=True):
        angle, lost = simulate_lost_motion(machine)
        axes.plot(angle, lost, color="#4C72B0", linewidth=1)
        axes.set_title(find_structure(name).title, fontsize=9)
        axes.set_xlabel("motor of joint 1, link side [mrad]")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("tool less motors [µm]")
    return figure


def simulate_lost_motion(machine: Machine) -> tuple[Array, Array]:
    """Simulate the triangle without compensation; motor angle of joint 1 [mrad], tool less motors along it [um]."""
    arm = RigidArm(machine.robot)
    reference = load_motion(arm, str(TRIANGLE)).reference
    (recording,) = simulate([Run(reference=reference, law=NoCompensation())], arm=arm, machine=[machine])
    motors = arm.robot.drive.joint_angle(recording.joint_array("motor.position"))
    lost = np.stack([recording[f"tcp.position.{axis}"] for axis in "xyz"], axis=1) - arm.tcp_position(motors)
    along = np.linalg.svd(lost - lost.mean(axis=0), full_matrices=False)[2][0]
    way = 1e3 * (motors[:, 0] - motors[0, 0])
    return way, 1e6 * (lost - lost.mean(axis=0)) @ along

"""What pages of docs/agents tell of the settings of laws, of files of estimators, and of tables beside them."""

import json
from collections.abc import Iterator
from inspect import signature

import numpy as np

from ffgym.agents.amortised.estimator import SILENT
from ffgym.agents.amortised.numbers import GROUPS
from ffgym.agents.artefacts import TRAINED
from ffgym.agents.feedback_error import N_STEPS
from ffgym.agents.iterative import TOLERANCES, TRIALS
from ffgym.agents.iterative_basis import N_BASIS, PRIOR_SPREAD
from ffgym.agents.law_files import FORMAT
from ffgym.agents.narx import N_EVALUATIONS
from ffgym.agents.online_lffc import RATE
from ffgym.agents.residual_torque import N_POINTS
from ffgym.agents.setpoint_rows import UNKNOWN_DELAY
from ffgym.agents.task_torques import SAME
from ffgym.control import DynamicLuGreEuler, DynamicLuGreExact
from ffgym.core.files import read_text
from ffgym.envs.settings import ACTION_SCALE
from ffgym.leaderboard.adaptation.protocol import LAP
from ffgym.leaderboard.comparison.samples import WORKCELLS
from ffgym.robot import load_robot
from ffgym.robot.friction import WIDTHS
from ffgym.simulation import PlantDistribution
from ffgym.studies.one_axis import FREQUENCIES
from scripts.claims.claim import claim
from scripts.claims.page import ROOT
from scripts.claims.records import numbers_of
from scripts.forgetting import SEEN_FROM, TOP_SPEED
from scripts.tables import laws
from scripts.tables.leaderboard import header_of, row_of
from scripts.tables.networks import select
from scripts.tables.page import rows_of
from scripts.tables.thesis import items

CODE = "the code itself"
RECORD = "python -m scripts.claims --record thesis"
DEMO = "python -m scripts.claims --record networks"
ESTIMATORS = "python -m scripts.train_estimator"
ELASTIC = ROOT / "docs" / "agents" / "elastic.md"
ELASTIC_AGAIN = "python -m scripts.tables --page agents/elastic.md"
ROBOT = "irb4600_60_205"


def agent_row(title: str) -> list[str]:
    """Row of an agent in the record of the thesis: track, trials, robot time, and errors at three speeds."""
    (row,) = (row[1:] for row in items()["agents"]["numbers"][0]["rows"] if row[0] == title)
    return [cell.split(" (")[0] for cell in row]


def trials(title: str) -> str:
    """Trials of an agent, and the time that the robot moves in them."""
    _, count, seconds, *_ = agent_row(title)
    return f"{count} trials, {seconds} s of robot time"


@claim(CODE)
def tolerances_of_iterative_learning() -> Iterator[str]:
    """Errors that are worth a correction by the Coulomb friction."""
    yield f"{1e3 * TOLERANCES['motor']:g} mrad at the motors, {1e3 * TOLERANCES['tcp']:g} mm at the tool"


@claim(CODE)
def motions_that_are_the_same() -> Iterator[str]:
    """Distance up to which a motion is known."""
    yield f"(to {SAME:.0e} rad)".replace("e-0", "e-")


@claim(RECORD)
def iterative_learning_on_circles() -> Iterator[str]:
    """Path errors of both members beside other laws."""
    titles = ("no compensation", "dynamic LuGre", "elastic feed-forward")
    learning = ("iterative learning on motor positions", "iterative learning on the tool's position")
    _, count, seconds, *_ = agent_row(learning[1])
    speeds = {row["speed_mm_s"] for row in select("none")}
    circles = len(select("none"))
    yield f"all {circles} circles, {count} trials, {seconds} s of robot time in all"
    yield f"RMS error of the tool over {TRIALS} trials from zero torque, {circles} circles"
    for k, speed in enumerate(sorted(speeds), start=3):
        cells = [agent_row(title)[k] for title in (*titles, *learning)]
        yield f"| {speed:g} mm/s | {' | '.join(cells)} |"


@claim(CODE)
def weights_of_basis_functions() -> Iterator[str]:
    """Weights that are learned, and their prior."""
    yield f"{N_BASIS * load_robot(ROBOT).n_joints} weights in all"
    yield f"under a prior spread of {PRIOR_SPREAD:g} on each"


@claim(CODE)
def rate_of_online_learning() -> Iterator[str]:
    """Rate, and how often it is applied."""
    yield f"The rate, {RATE:g}, is smaller"
    yield f"as it is applied {1 / load_robot(ROBOT).servo.control_dt:.0f} times a second"


def estimator(name: str) -> dict[str, tuple[int, ...]]:
    """Shapes of the arrays of the first seed of an estimator."""
    with np.load(TRAINED / name / "any" / "seed_0.npz") as file:
        return {key: file[key].shape for key in file.files}


@claim(ESTIMATORS)
def size_of_the_estimator() -> Iterator[str]:
    """Numbers that are read, and the layers that read them."""
    shapes = estimator("amortised")
    count = len(GROUPS) * load_robot(ROBOT).n_joints + 1
    assert shapes["linear_weight"][0] == count
    assert shapes["layer_0_weight"][0] == shapes["layer_1_weight"][0]
    yield f"A network learns to read {count} numbers of the machine"
    yield f"and two layers of {shapes['layer_0_weight'][0]}, which"


@claim(ESTIMATORS)
def cells_of_the_estimator() -> Iterator[str]:
    """Cells of the recurrent network."""
    yield f"a long short-term memory of {estimator('amortised_recurrent')['lstm_hidden_weight'][1]} cells"


@claim(CODE)
def silence_of_the_estimator() -> Iterator[str]:
    """Difference up to which nominal numbers stay."""
    yield f"(at {SILENT:g}; drawn workcells"


def lap(name: str) -> str:
    """Circle of the lap on a machine, and the time that it takes."""
    seconds = row_of(WORKCELLS, name).score.robot_seconds
    return f"at position p1 with {1e3 * LAP[0]:g} mm at {1e3 * LAP[1]:g} mm/s, {seconds:.1f} s with its rests"


@claim("ffgym leaderboard --agents amortised")
def lap_of_the_estimator() -> Iterator[str]:
    """The lap that is run first."""
    yield lap("amortised")


@claim("ffgym leaderboard --agents fitted")
def lap_of_the_fit() -> Iterator[str]:
    """The lap that is run first."""
    yield lap("fitted")


@claim(ESTIMATORS)
def explained_by_the_estimator() -> Iterator[str]:
    """Share of variance that the first estimate explains."""
    titles = {
        "coulomb": "Coulomb friction",
        "arm_share": "share of friction on the arm",
        "asymmetry": "asymmetry of friction",
        "payload": "payload",
        "bristle_stiffness": "bristle stiffness",
        "bristle_damping": "bristle damping",
        "viscous": "viscous friction",
        "joint_stiffness": "joint stiffness",
        "falling_friction": "falling friction",
        "load_friction": "friction by load",
        "rotor_inertia": "rotor inertia",
        "link_inertia": "link inertia",
        "hysteresis": "hysteresis",
        "stribeck_velocity": "Stribeck velocity",
    }
    tracker, motors = (header_of(name)["meta"]["explained"] for name in ("amortised", "amortised_motors"))
    for group, title in titles.items():
        yield f"| {title} | {tracker[group]:.2f}; {motors[group]:.2f} |"


@claim(ESTIMATORS)
def draws_of_the_estimator() -> Iterator[str]:
    """Seeds, laps and simulated time of the training."""
    files = json.loads(read_text(TRAINED / "amortised" / "manifest.json"))["artefacts"]
    yield f"There are {len(files)} seeds of each."
    seconds = files[0]["env_steps"] * load_robot(ROBOT).servo.control_dt
    laps = seconds / row_of(WORKCELLS, "amortised").score.robot_seconds
    yield f"Draws cost {laps:.0f} laps ({seconds:.0f} s of simulated motion)"


@claim(CODE)
def sub_steps_and_memory() -> Iterator[str]:
    """Sub-steps of friction on the arm."""
    yield f"solved in {DynamicLuGreExact.n_substeps} sub-steps"


@claim(CODE)
def damping_of_springs() -> Iterator[str]:
    """Time of the springs beside that of a control step."""
    robot = load_robot(ROBOT)
    slowest = float((robot.drive.joint_damping / robot.drive.joint_stiffness).max())
    yield f"({1e3 * slowest:g} ms against {1e3 * robot.servo.control_dt:g} ms here)"


@claim(DEMO)
def circles_of_a_speed() -> Iterator[str]:
    """Circles of each speed."""
    yield f"mean RMS path error of {len(select('none', 10.0))} circles"


@claim(ELASTIC_AGAIN)
def parts_of_elastic_feed_forward() -> Iterator[str]:
    """What the law takes off, and what wrong parameters cost."""
    rows = {name: [float(value) for value in values] for name, *values in rows_of(ELASTIC, "laws")}
    pairs = zip(agent_row("elastic feed-forward")[3:], agent_row("dynamic LuGre")[3:], strict=True)
    slow, medium, fast = (1 - float(left) / float(most) for left, most in pairs)
    yield (
        f"it takes off {100 * slow:.0f} % at 10 mm/s, {100 * medium:.1f} % at 40 mm/s and {100 * fast:.1f} % at "
        "100 mm/s."
    )
    alone = [value for name in ("lugre_dynamic", "springs without friction") for value in rows[name][1:]]
    yield f"either alone leaves {min(alone):.2f} mm or more"
    wrong = {
        part: sorted({int(name.removeprefix(part).strip(" %").lstrip("+-")) for name in rows if name.startswith(part)})
        for part in ("stiffness", "friction")
    }
    yield f"With a stiffness that is {wrong['stiffness'][-1]} % wrong"
    costs = [
        value - own
        for name, values in rows.items()
        if name.startswith("friction")
        for value, own in zip(values, rows["elastic"], strict=True)
    ]
    yield f"friction that is {wrong['friction'][0]} % wrong costs {min(costs):.2f} to {max(costs):.2f} mm at any speed"


@claim(CODE)
def samples_of_a_turn() -> Iterator[str]:
    """Samples of the smallest circle at the highest speed."""
    dt = load_robot(ROBOT).servo.control_dt
    turn = 2 * np.pi * min(row["radius_mm"] for row in select("none")) / 100
    yield f"then {1e3 * dt:g} ms samples, of which a turn has {turn / dt:.0f}."


@claim(ELASTIC_AGAIN)
def largest_share() -> Iterator[str]:
    """What is left at the largest share of friction on the arm."""
    rows = rows_of(ELASTIC, "shares")
    share = rows[-1][0]
    yield f"What is left at a share of {share}, seen"
    yield f"samples of {1e3 * load_robot(ROBOT).servo.control_dt:g} ms at 100 mm/s"
    (learned,) = ([float(value) for value in row[2:]] for row in rows if row[:2] == [share, "`ilc_tcp`"])
    yield f"leaves {max(learned):g} mm or less (`ilc_tcp`)"


@claim(DEMO)
def lugre_on_one_axis() -> Iterator[str]:
    """Motor error that dynamic LuGre removes on one axis."""
    rows = {
        row["frequency_hz"]: row["reduction"]
        for row in numbers_of("networks")["one_axis"]
        if row["agent"] == "lugre_dynamic"
    }
    slow, fast = (100 * rows[frequency] for frequency in FREQUENCIES)
    yield f"{slow:.1f} % and {fast:.1f} % of the motor error at {FREQUENCIES[0]:g} and {FREQUENCIES[1]:g} Hz"


@claim(CODE)
def fit_of_narx() -> Iterator[str]:
    """Evaluations of a fit, and its sample time."""
    yield f"with at most {N_EVALUATIONS} evaluations"
    yield f"noise; {1e3 * load_robot(ROBOT).servo.control_dt:g} ms instead of"


@claim(RECORD)
def trials_of_narx() -> Iterator[str]:
    """Trials and robot time."""
    yield trials("NARX network")


@claim(RECORD)
def trials_of_the_perceptron() -> Iterator[str]:
    """Trials and robot time."""
    yield trials("perceptron, feedback-error learning")


@claim(RECORD)
def trials_of_the_residual_torque_model() -> Iterator[str]:
    """Trials and robot time."""
    yield trials("residual torque model")


@claim(CODE)
def updates_of_the_perceptron() -> Iterator[str]:
    """Steps of an update."""
    yield f"{N_STEPS} full-batch steps of Adam"


@claim(CODE)
def speeds_that_come_again() -> Iterator[str]:
    """Speeds of the second stage."""
    yield f"then it runs between {SEEN_FROM:g} and {TOP_SPEED:g} rad/s only"


@claim(CODE)
def spread_of_drawn_machines() -> Iterator[str]:
    """Spread of stiffness and masses, and the largest payload."""
    drawn = PlantDistribution()
    stiffness, masses, payload = (getattr(drawn, name).high for name in ("joint_stiffness", "link_inertia", "payload"))
    yield (
        f"stiffness by {100 * (stiffness - 1):.0f} %, masses by {100 * (masses - 1):.0f} %, up to {payload:g} kg of "
        "payload"
    )


@claim(ELASTIC_AGAIN)
def oracle_on_the_nominal_machine() -> Iterator[str]:
    """Errors of elastic feed-forward with true numbers."""
    (row,) = (row[1:] for row in rows_of(ELASTIC, "laws") if row[0] == "elastic")
    yield f"it is `elastic` ({row[0]}, {row[1]} and {row[2]} mm at 10, 40 and 100 mm/s)"


@claim(CODE)
def parts_of_the_residual_torque_model() -> Iterator[str]:
    """Widths of slip elements, and samples of the process."""
    *first, last = (f"{1e3 * width:g}" for width in WIDTHS)
    yield f"s⁺ = clip(s + Δq/w, ±1), for w = {', '.join(first)} and {last} mrad of the"
    yield f"kept at {N_POINTS} samples per motor"


@claim(CODE)
def steps_of_lugre() -> Iterator[str]:
    """Euler steps of the thesis, and the scale of actions."""
    yield f"takes the {DynamicLuGreEuler.n_substeps} Euler steps of the thesis"
    yield f"the default `action_scale` of {ACTION_SCALE:g} breakaway torques"


@claim(CODE)
def sub_steps_of_the_model() -> Iterator[str]:
    """Sub-steps of the motors."""
    yield f"averaged around samples in {DynamicLuGreExact.n_substeps} sub-steps"


@claim("python -m scripts.tables --page agents/model.md")
def sizes_of_effects() -> Iterator[str]:
    """Share of the strongest plausible size, and the circles."""
    chosen = {name: each.default for name, each in signature(laws.model).parameters.items()}
    small, large = (1e3 * radius for radius in chosen["radii"])
    yield f"at {chosen['share']:g} of the strongest plausible size, circles of {small:g} and {large:g} mm at p2"


@claim(CODE)
def late_set_points() -> Iterator[str]:
    """Delay that the sender does not know of."""
    yield f"on time and {1e3 * UNKNOWN_DELAY:g} ms late"


@claim(CODE)
def format_of_law_files() -> Iterator[str]:
    """Format of the files."""
    yield f"`format` ({FORMAT})"

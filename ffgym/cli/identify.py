"""`ffgym identify`: parameters of a robot from its logs, as a file that every agent and plant accepts."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from ffgym.cli.descriptions import described_robot
from ffgym.cli.identify_kinds import Outcome, identified_friction, identified_rigid_body
from ffgym.cli.identify_logs import LogSet, read_logs
from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.cli.unused import given_options
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.files import write_json, write_text
from ffgym.diagnosis.identification.parameter_file import parameter_text
from ffgym.diagnosis.identification.resampling import LEVEL, RESAMPLES
from ffgym.robot import load_draft, with_parameters

What = Literal["friction", "rigid_body"]

_ONLY = {"friction": ("joints", "stribeck_velocity"), "rigid_body": ("terms", "spread")}
"""Options that only one kind of identification has."""


@dataclass(frozen=True)
class Identify:
    """Identify parameters from logs; print them beside the old ones, with intervals, and how well they hold."""

    logs: tyro.conf.Positional[tuple[Path, ...]]
    """Recordings, .npz or .csv, or folders of them; files of other tools with --columns."""
    robot: str
    """Built-in robot, or a path to a description that ends in .toml, as it is known before."""
    out: Path | None = None
    """Parameter file to write, .toml."""
    what: What = "friction"
    """friction: LuGre parameters of all joints. rigid_body: masses, rotors, Coulomb and viscous friction, offsets; the
    robot may lack masses."""
    columns: str | None = None
    """Column map for files of other tools: a built-in name, or a file that ends in .toml."""
    validate: tuple[Path, ...] = ()
    """Recordings or folders that are not used but tell how well old and new parameters hold. Those among the logs are
    kept out."""
    joints: tuple[str, ...] = ()
    """Joints to identify; none given is all."""
    stribeck_velocity: float | None = None
    """Stribeck velocity to keep on all joints, motor side [rad/s]; none given estimates it."""
    terms: tuple[str, ...] = ()
    """Parts of the torque that a rigid body is fitted with; none given is bodies, rotor_inertia, coulomb, viscous,
    offset. There are springs and viscous_asymmetry too."""
    spread: float | None = None
    """How far masses and rotors may be from the description, a relative standard deviation, e.g. 0.03 for CAD; none
    given is what predicts held-out parts of the logs best."""
    cutoff_hz: float | None = None
    """Cut-off of the low-pass filter of angles and torques, which must lie below half the sample rate; none given is
    100 Hz for friction and 5 Hz for a rigid body."""
    resamples: int = RESAMPLES
    """Resamples behind the intervals."""
    level: float = LEVEL
    """Probability of the intervals."""
    seed: int = 0
    """Of random starts and resamples."""
    unchecked: bool = False
    """Use logs that the quality gate calls insufficient."""
    json: Path | None = None
    """Also write every number to this file."""
    report: Path | None = None
    """Page with pictures to write, .html, in one file that can be sent."""

    def run(self) -> None:
        """Check, identify, write, print."""
        self._check()
        if self.what == "friction":
            robot = described_robot(self.robot)
            logs = read_logs(robot, self.logs, self.validate, columns=self.columns, unchecked=self.unchecked)
            outcome = identified_friction(self, robot, logs)
        else:
            draft = load_draft(self.robot)
            robot = draft.description_for("identification")
            known = not draft.missing
            logs = read_logs(
                robot, self.logs, self.validate, columns=self.columns, unchecked=self.unchecked, known=known
            )
            outcome = identified_rigid_body(self, draft, logs)
        info = provenance("ffgym identify", self, robot.name, None, self.seed)
        self._write(outcome, logs, info)
        print(outcome.text)
        for what, place in (("parameters", self.out), ("report", self.report), ("numbers", self.json)):
            if place is not None:
                print(f"{what}: {place}")

    def _check(self) -> None:
        """Refuse what cannot be run or written."""
        if not self.logs:
            raise FFGymError("There are no logs to identify from. Name recordings, or folders of them.")
        for what, names in _ONLY.items():
            if what != self.what and (given := given_options(self, names)):
                raise FFGymError(f"{', '.join(given)} has no effect on --what {self.what}. Leave it out.")
        check_whole("--resamples", self.resamples, low=2)
        check_whole("--seed", self.seed, low=0)
        check_number("--level", self.level, low=0.0, high=0.999, open_low=True)
        if self.out is not None and self.out.suffix != ".toml":
            raise FFGymError(f"--out {self.out}: the name must end in .toml.")
        if self.report is not None:
            need_extra("The report", "matplotlib", "jinja2")
        inputs: tuple[str | Path | None, ...] = (self.robot, self.columns, *self.logs, *self.validate)
        check_outputs({"--out": self.out, "--report": self.report, "--json": self.json}, inputs=inputs)

    def _write(self, outcome: Outcome, logs: LogSet, info: dict[str, object]) -> None:
        """Files first: nobody may read what is printed."""
        if self.out is not None:
            if not outcome.quantities:
                raise FFGymError(
                    "The logs tell none of the parameters, so there is nothing to write. Use other motions."
                )
            path = self._description(self.out)
            write_text(self.out, parameter_text(logs.robot, outcome.quantities, outcome.title, path))
            with_parameters(logs.robot, self.out)
        if self.report is not None:
            write_text(self.report, outcome.page(info))
        if self.json is not None:
            write_json(self.json, info | dict(outcome.numbers))

    def _description(self, out: Path) -> str | None:
        """Path of the user's own description from the folder of the parameter file, which so finds its robot."""
        if not self.robot.endswith(".toml"):
            return None
        return Path(os.path.relpath(Path(self.robot).resolve(), out.resolve().parent)).as_posix()

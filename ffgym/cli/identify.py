"""`ffgym identify`: parameters of a robot from its logs, as a file that every agent and plant accepts."""

import os
from pathlib import Path

from ffgym.cli.identify_kinds import identified_friction, identified_rigid_body
from ffgym.cli.identify_logs import read_logs
from ffgym.cli.log_options import Identify
from ffgym.cli.outputs import check_outputs, given_options, print_places, provenance, write_numbers
from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.files import write_text
from ffgym.diagnosis.identification.parameter_file import parameter_text
from ffgym.envs.machines import described_robot
from ffgym.robot import load_draft, with_parameters

_ONLY = {"friction": ("joints", "stribeck_velocity"), "rigid_body": ("terms", "spread")}
"""Options that only one kind of identification has."""


def run(config: Identify) -> None:
    """Check, identify, write, print."""
    _check(config)
    if config.what == "friction":
        robot = described_robot(config.robot)
        outcome = identified_friction(config, robot, read_logs(config, robot))
    else:
        draft = load_draft(config.robot)
        robot = draft.description_for("identification")
        outcome = identified_rigid_body(config, draft, read_logs(config, robot, known=not draft.missing))
    info = provenance("ffgym identify", config, robot.name, None, config.seed)
    # files first: nobody may read what is printed
    if config.out is not None:
        if not outcome.quantities:
            raise FFGymError("The logs tell none of the parameters, so there is nothing to write. Use other motions.")
        description = None
        if config.robot.endswith(".toml"):  # the user's own, which the file so finds from its folder
            relative = os.path.relpath(Path(config.robot).resolve(), config.out.resolve().parent)
            description = Path(relative).as_posix()
        write_text(config.out, parameter_text(robot, outcome.quantities, outcome.title, description))
        with_parameters(robot, config.out)
    if config.report is not None:
        write_text(config.report, outcome.page(info))
    write_numbers(config, info | dict(outcome.numbers))
    print(outcome.text)
    print_places(parameters=config.out, report=config.report, numbers=config.json)


def _check(config: Identify) -> None:
    """Refuse what cannot be run or written."""
    if not config.logs:
        raise FFGymError("There are no logs to identify from. Name recordings, or folders of them.")
    for what, names in _ONLY.items():
        if what != config.what and (given := given_options(config, names)):
            raise FFGymError(f"{', '.join(given)} has no effect on --what {config.what}. Leave it out.")
    check_whole("--resamples", config.resamples, low=2)
    check_whole("--seed", config.seed, low=0)
    check_number("--level", config.level, low=0.0, high=0.999, open_low=True)
    inputs = (config.robot, config.columns, *config.logs, *config.validate)
    places = {"--out": config.out, "--report": config.report, "--json": config.json}
    check_outputs(places, inputs=inputs, suffix=".toml")

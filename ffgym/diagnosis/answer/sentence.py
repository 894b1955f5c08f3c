"""The verdict in one sentence."""

from collections.abc import Sequence

from ffgym.diagnosis.answer.verdict import Judged
from ffgym.diagnosis.result import Cause, Pattern
from ffgym.robot import RobotDescription


def sentence_of(judged: Judged, causes: Sequence[Cause], patterns: Sequence[Pattern], robot: RobotDescription) -> str:
    """What a diagnosis says, in one sentence."""
    named = ", and ".join(_named(cause) for cause in causes)
    share = f"{100 * min(judged.removed, 1.0):.0f} %"
    if judged.verdict == "none":
        return f"These motions do not falsify the model of {robot.name}: what is left is noise and calibration."
    if judged.verdict == "unknown":
        what = patterns[0].message if patterns else "nothing that was looked for"
        return f"Something is there that no effect of the library explains; what is left depends on: {what}."
    if judged.verdict == "ambiguous":
        rivals = " or ".join(_place(r.effect, r.joint) for r in judged.rivals if r.tied)
        return f"Consistent with {named}; but {rivals} would explain these motions as well."
    if judged.verdict == "partly":
        left = f"; what is left depends on: {patterns[0].message}" if patterns else ", and something is left"
        if judged.stretched:
            left = f", and {judged.stretched[0]} is at the end of what is plausible: it may stand for something else"
        return f"Partly explained by {named}: that removes {share} of what noise does not explain{left}."
    return f"Consistent with {named}, which removes {share} of what noise does not explain."


def _named(cause: Cause) -> str:
    return f"{cause.title} {'of ' + cause.joint if cause.joint else ''}".strip()


def _place(effect: str, joint: str) -> str:
    return f"{effect.replace('_', ' ')} of {joint}" if joint else effect.replace("_", " ")

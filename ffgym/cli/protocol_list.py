"""The protocols as a table: how many motions, how long they take on a robot, and what they serve."""

from textwrap import fill

from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm
from ffgym.simulation.protocols import PROTOCOLS
from ffgym.simulation.protocols.stage import Stage


def protocol_list(arm: RigidArm) -> str:
    """Text with one paragraph for each protocol; one that the robot cannot run says why."""
    paragraphs = [
        f"On {arm.robot.name!r}, with default settings (docs/protocols.md); durations are those of the motions."
    ]
    for name, protocol in PROTOCOLS.items():
        try:
            motions = protocol().motions(Stage(arm=arm))  # without the torques, which take longer to look at
        except FFGymError as error:
            size = f"cannot be run: {error}"
        else:
            number = f"{len(motions)} motion{'s' if len(motions) > 1 else ''}"
            size = f"{number}, {sum(motion.reference.duration for motion in motions):.0f} s"
        paragraphs.append(fill(f"{name}: {size}. {protocol.purpose[0].upper()}{protocol.purpose[1:]}.", 110))
    return "\n".join(paragraphs)

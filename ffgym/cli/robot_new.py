"""`ffgym robot new`: a table to fill in for the arm of an MJCF or URDF file."""

import os
from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable, write_text
from ffgym.robot.arm_file import read_arm
from ffgym.robot.reading.parse import parse_draft
from ffgym.robot.template import filled_text, propose, template


@dataclass(frozen=True)
class New:
    """Write a commented table for the arm of an MJCF or URDF file: what is known, and a place for what is not."""

    arm: tyro.conf.Positional[Path]
    """MJCF (.xml) or URDF (.urdf) file."""
    out: Path = Path("my_robot.toml")
    """Description to write, .toml; its name is the robot's name."""
    joints: tuple[str, ...] = ()
    """Joints that move, from the base outwards; none given is all. Others, e.g. a gripper's, are held."""
    tool_frame: str | None = None
    """Frame of the last link (site, body or fixed link) that is tool0; none given takes one with a usual name."""
    looks: bool = True
    """Take shapes and meshes; with no-looks, missing meshes do not matter."""
    force: bool = False
    """Write over a file that is there."""

    def run(self) -> None:
        """Read the arm, write the table."""
        if self.out.suffix != ".toml":
            raise FFGymError(f"{self.out}: the suffix is {self.out.suffix!r}, a description must end in .toml.")
        if self.out.exists() and not self.force:
            raise FFGymError(f"{self.out} is there already, and may hold your work; --force writes over it.")
        check_writable(self.out)
        joints = self.joints or None
        arm = read_arm(self.arm, joints, looks=self.looks)
        model = Path(os.path.relpath(self.arm.resolve(), self.out.resolve().parent)).as_posix()
        text = template(self.out.stem, arm, model, joints=joints, tool_frame=self.tool_frame, looks=self.looks)
        draft = parse_draft(text, where=str(self.out), folder=self.out.parent)
        text = filled_text(text, propose(draft), draft.types)
        missing = parse_draft(text, where=str(self.out), folder=self.out.parent).missing
        write_text(self.out, text)
        print(f"wrote {self.out}: {len(arm.joints)} joints, {', '.join(arm.joints)}; missing: {', '.join(missing)}")
        for note in arm.notes:
            print(f"note: {note}")
        print(f"next: put numbers into {self.out} where '#?' waits for them, then ffgym robot fill {self.out}")

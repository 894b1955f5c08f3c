"""A six-axis arm as a user might have it, and what its table is filled in with."""

from tests.robot import toml_entries

ARM = """<mujoco model="cutter">
  <compiler angle="radian"/>
  <worldbody>
    <body name="base">
      <inertial pos="0 0 0.1" mass="40" diaginertia="1 1 1"/>
      <body name="column" pos="0 0 0.40">
        <joint name="j1" axis="0 0 1" range="-3 3"/>
        <inertial pos="0.05 0 -0.1" mass="60" diaginertia="1.2 1.2 0.9"/>
        <body name="upper" pos="0.15 0 0">
          <joint name="j2" axis="0 1 0" range="-1.5 2.0"/>
          <inertial pos="0 0 0.3" mass="30" diaginertia="1.4 1.4 0.15"/>
          <body name="fore" pos="0 0 0.70">
            <joint name="j3" axis="0 1 0" range="-2.5 1.2"/>
            <inertial pos="0.1 0 0.1" mass="25" diaginertia="0.4 0.5 0.4"/>
            <body name="roll" pos="0 0 0.12">
              <joint name="j4" axis="1 0 0" range="-3 3"/>
              <inertial pos="0.45 0 0" mass="12" diaginertia="0.06 0.4 0.4"/>
              <body name="wrist" pos="0.72 0 0">
                <joint name="j5" axis="0 1 0" range="-2.1 2.1"/>
                <inertial pos="0 0 0" mass="4" diaginertia="0.01 0.012 0.01"/>
                <body name="flange" pos="0.10 0 0">
                  <joint name="j6" axis="1 0 0" range="-6 6"/>
                  <inertial pos="0 0 0" mass="3" diaginertia="0.006 0.004 0.004"/>
                  <site name="tcp" pos="0.20 0 -0.05" euler="0 1.5707963267948966 0"/>
                </body>
              </body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def entry(path: str, value: object, unit: str, side: str | None = None) -> str:
    """TOML text of an entry, as a user who has data sheets writes it."""
    return "\n" + toml_entries.entry(path, value, unit, side, origin="sourced", source="data sheet")


NUMBERS = {
    "kinematics.max_speed": entry("kinematics.max_speed", [150, 130, 150, 260, 260, 400], "deg/s", "link"),
    "drive.gear_ratio": entry("drive.gear_ratio", [110, 120, 100, 60, 60, 50], "1"),
    "drive.rotor_inertia": entry("drive.rotor_inertia", [18, 18, 12, 3, 3, 2], "kg cm^2", "motor"),
    "drive.joint_stiffness": entry("drive.joint_stiffness", [4e5, 4e5, 2.5e5, 4e4, 4e4, 3e4], "N m/rad", "link"),
    "drive.peak_torque": entry("drive.peak_torque", [16, 20, 12, 4, 4, 3], "N m", "motor"),
    "friction.coulomb": entry("friction.coulomb", [0.45, 0.5, 0.35, 0.12, 0.14, 0.12], "N m", "motor"),
    "friction.viscous": entry("friction.viscous", [0.02, 0.02, 0.015, 0.004, 0.004, 0.004], "N m s/rad", "motor"),
}
"""What a user must know, by entry; the rest follows by rules of thumb."""

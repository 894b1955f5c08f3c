"""Joint positions, speeds and accelerations for poses and paths of the tool, for serial arms of any kind."""

from ffgym.robot.inverse_kinematics.mobility import MAX_CONDITION as MAX_CONDITION
from ffgym.robot.inverse_kinematics.newton import solve_twist as solve_twist
from ffgym.robot.inverse_kinematics.path import solve_path as solve_path
from ffgym.robot.inverse_kinematics.poses import pose_solutions as pose_solutions
from ffgym.robot.inverse_kinematics.poses import solve_pose as solve_pose
from ffgym.robot.inverse_kinematics.rates import joint_rates as joint_rates
from ffgym.robot.inverse_kinematics.rotation import rotation_error as rotation_error

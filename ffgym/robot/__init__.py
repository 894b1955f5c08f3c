"""Robots: descriptions with the origin of every number, their MuJoCo models, kinematics and rigid dynamics."""

from ffgym.robot.arm import RigidArm as RigidArm
from ffgym.robot.capabilities import CAPABILITIES as CAPABILITIES
from ffgym.robot.capabilities import Capability as Capability
from ffgym.robot.description import RobotDescription as RobotDescription
from ffgym.robot.draft import RobotDraft as RobotDraft
from ffgym.robot.elasticity import resonances as resonances
from ffgym.robot.elasticity import static_deflection as static_deflection
from ffgym.robot.fingerprint import model_bytes as model_bytes
from ffgym.robot.fingerprint import model_field as model_field
from ffgym.robot.fingerprint import physics_fingerprint as physics_fingerprint
from ffgym.robot.inverse_kinematics import pose_solutions as pose_solutions
from ffgym.robot.inverse_kinematics import solve_path as solve_path
from ffgym.robot.inverse_kinematics import solve_pose as solve_pose
from ffgym.robot.load import builtin_robots as builtin_robots
from ffgym.robot.load import load_draft as load_draft
from ffgym.robot.load import load_robot as load_robot
from ffgym.robot.load import parse_robot as parse_robot
from ffgym.robot.load import robot_of as robot_of
from ffgym.robot.mjcf import mjcf_text as mjcf_text
from ffgym.robot.motor_torque import MotorTorque as MotorTorque
from ffgym.robot.motor_torque import motor_torque as motor_torque
from ffgym.robot.parameters import with_parameters as with_parameters
from ffgym.robot.parts import Servo as Servo
from ffgym.robot.spec import ModelOptions as ModelOptions
from ffgym.robot.spec import build_spec as build_spec
from ffgym.robot.spec import compile_model as compile_model

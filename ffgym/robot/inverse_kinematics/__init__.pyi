from .newton import MAX_CONDITION as MAX_CONDITION
from .newton import joint_rates as joint_rates
from .newton import rotation_error as rotation_error
from .newton import solve_twist as solve_twist
from .poses import pose_solutions as pose_solutions
from .poses import solve_path as solve_path
from .poses import solve_pose as solve_pose

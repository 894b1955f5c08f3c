# robots
from .agents import LawAgent as LawAgent
from .agents import elastic_feedforward as elastic_feedforward

# feed-forward laws, agents
from .control import (
    CausalLaw as CausalLaw,
)
from .control import (
    DynamicLuGreExact as DynamicLuGreExact,
)
from .control import (
    FeedForwardLaw as FeedForwardLaw,
)
from .control import (
    NoCompensation as NoCompensation,
)
from .control import (
    StaticLuGre as StaticLuGre,
)

# errors
from .core.errors import FFGymError as FFGymError

# from logs to parameters and causes
from .diagnosis import (
    Diagnosis as Diagnosis,
)
from .diagnosis import (
    diagnose as diagnose,
)
from .diagnosis import (
    identify_friction as identify_friction,
)
from .diagnosis import (
    identify_rigid_body as identify_rigid_body,
)
from .diagnosis import (
    read_diagnosis as read_diagnosis,
)

# physical effects, machines
from .effects import EFFECTS as EFFECTS
from .effects import Effect as Effect
from .logs import check_quality as check_quality
from .logs import read_log as read_log

# motions
from .paths import (
    Reference as Reference,
)
from .paths import (
    cartesian_reference as cartesian_reference,
)
from .paths import (
    circle_test as circle_test,
)
from .paths import (
    joint_reference as joint_reference,
)
from .paths import (
    joint_sine as joint_sine,
)
from .paths import (
    load_motion as load_motion,
)
from .paths import (
    multisine as multisine,
)

# recordings, logs
from .recordings import (
    Header as Header,
)
from .recordings import (
    Phase as Phase,
)
from .recordings import (
    Recording as Recording,
)
from .recordings import contour_errors as contour_errors
from .recordings import motor_error_rms as motor_error_rms
from .recordings import path_errors as path_errors
from .recordings import (
    read_folder as read_folder,
)
from .recordings import (
    read_recording as read_recording,
)
from .recordings import (
    write_recording as write_recording,
)
from .robot import RigidArm as RigidArm
from .robot import RobotDescription as RobotDescription
from .robot import load_robot as load_robot
from .robot import with_parameters as with_parameters
from .simulation import (
    Climate as Climate,
)

# simulation
from .simulation import (
    LaserTracker as LaserTracker,
)
from .simulation import (
    Machine as Machine,
)
from .simulation import (
    PlantDistribution as PlantDistribution,
)
from .simulation import (
    Resolver as Resolver,
)
from .simulation import (
    Run as Run,
)
from .simulation import (
    SimulatedRig as SimulatedRig,
)
from .simulation import (
    export_run as export_run,
)
from .simulation import (
    load_machine as load_machine,
)
from .simulation import (
    plan_session as plan_session,
)
from .simulation import (
    record as record,
)
from .simulation import (
    save_machine as save_machine,
)
from .simulation import (
    sensors_of as sensors_of,
)
from .simulation import (
    simulate as simulate,
)

"""Chapter 05: how does the robot stay on its path, and how fast may it go there?

    path → speed_profile → (pure_pursuit → curvature → wheels)      a robot that steers
                           (follow_path → twist → modules)          a robot that drives anywhere
    setpoint, measurement → Pid → actuator

================  ==================================================================
``pid``           `Pid` with limits, anti-windup and no kick; the same as a pure step
``incremental``   the form that adds changes to the last output
``tuning``        gains from an oscillation (Ziegler and Nichols), and how to find it
``polyline``      nearest point and look-ahead point of a path
``pursuit``       the circle that leads to the look-ahead point
``profile``       curvature of a path, and the speed it allows at each point
``following``     path and speeds -> velocity of a swerve robot
``differential``  a robot with two wheels to practise on
================  ==================================================================
"""

from robocon_course.tracking.differential import (
    DifferentialModel,
    DifferentialState,
    differential_step,
    wheel_speeds,
)
from robocon_course.tracking.following import (
    FollowerState,
    LookAhead,
    PathFollower,
    PathTwist,
    follow_path,
)
from robocon_course.tracking.incremental import IncrementalPid
from robocon_course.tracking.pid import (
    Pid,
    PidGains,
    PidLimits,
    PidState,
    PidTerms,
    pid_step,
)
from robocon_course.tracking.polyline import PathPoint, nearest_point
from robocon_course.tracking.profile import path_curvature, profile_times, speed_profile
from robocon_course.tracking.pursuit import Pursuit, lookahead_distance, pure_pursuit
from robocon_course.tracking.tuning import (
    Critical,
    NoOscillationError,
    Oscillation,
    critical_gain,
    find_oscillation,
    ziegler_nichols,
)

__all__ = [
    "Critical",
    "DifferentialModel",
    "DifferentialState",
    "FollowerState",
    "IncrementalPid",
    "LookAhead",
    "NoOscillationError",
    "Oscillation",
    "PathFollower",
    "PathPoint",
    "PathTwist",
    "Pid",
    "PidGains",
    "PidLimits",
    "PidState",
    "PidTerms",
    "Pursuit",
    "critical_gain",
    "differential_step",
    "find_oscillation",
    "follow_path",
    "lookahead_distance",
    "nearest_point",
    "path_curvature",
    "pid_step",
    "profile_times",
    "pure_pursuit",
    "speed_profile",
    "wheel_speeds",
    "ziegler_nichols",
]

"""Chapter 05: how does the robot stay on its path, and how fast may it go there?

    path → speed_profile → speed ┐
    path, pose → pure_pursuit → curvature → turn rate of a cart, course of a swerve robot
    setpoint, measurement → pid_step → actuator

================  ==================================================================
``pid``           `Pid` with limits, anti-windup and no kick; the same as a pure step
``incremental``   the form that adds changes to the last output
``tuning``        gains from an oscillation (Ziegler and Nichols), and how to find it
``polyline``      nearest point and look-ahead point of a path
``along``         the nearest points to a whole drive
``pursuit``       the circle that leads to the look-ahead point
``profile``       curvature of a path, and the speed it allows at each point
``differential``  a robot with two wheels to practise on
``cart``          the same with its own odometry
``trial``         its whole loop along a path, with faults; kernels in ``loop``
``search``        settings for a robot and a path, found by trials
================  ==================================================================
"""

from robocon_course.tracking.along import REACH, PathPoints, nearest_points
from robocon_course.tracking.cart import Cart
from robocon_course.tracking.differential import (
    DT,
    DifferentialModel,
    DifferentialState,
    differential_step,
    wheel_speeds,
)
from robocon_course.tracking.incremental import IncrementalPid
from robocon_course.tracking.loop import ARRIVED, CREEP
from robocon_course.tracking.pid import (
    Pid,
    PidGains,
    PidLimits,
    PidState,
    PidTerms,
    pid_step,
)
from robocon_course.tracking.polyline import PathPoint, lookahead_point, nearest_point
from robocon_course.tracking.profile import path_curvature, profile_times, speed_profile
from robocon_course.tracking.pursuit import TOLERANCE, Pursuit, lookahead_distance, pure_pursuit
from robocon_course.tracking.search import tune
from robocon_course.tracking.trial import (
    ACCEL,
    Faults,
    TrackingSettings,
    Trial,
    start_pose,
    time_allowed,
    trial,
)
from robocon_course.tracking.tuning import (
    Critical,
    NoOscillationError,
    Oscillation,
    critical_gain,
    find_oscillation,
    ziegler_nichols,
)

__all__ = [
    "ACCEL",
    "ARRIVED",
    "CREEP",
    "DT",
    "REACH",
    "TOLERANCE",
    "Cart",
    "Critical",
    "DifferentialModel",
    "DifferentialState",
    "Faults",
    "IncrementalPid",
    "NoOscillationError",
    "Oscillation",
    "PathPoint",
    "PathPoints",
    "Pid",
    "PidGains",
    "PidLimits",
    "PidState",
    "PidTerms",
    "Pursuit",
    "TrackingSettings",
    "Trial",
    "critical_gain",
    "differential_step",
    "find_oscillation",
    "lookahead_distance",
    "lookahead_point",
    "nearest_point",
    "nearest_points",
    "path_curvature",
    "pid_step",
    "profile_times",
    "pure_pursuit",
    "speed_profile",
    "start_pose",
    "time_allowed",
    "trial",
    "tune",
    "wheel_speeds",
    "ziegler_nichols",
]

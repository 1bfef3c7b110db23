"""Chapter 02: where is the robot, if all it has is three wheels that count?

    ticks → travel d = 2πr · counts / counts_per_turn → A Δ = d → pose ← pose ∘ exp(Δ)

Each dead wheel feels one component of the body's motion; three of them, or more, give all of it.
Errors of size and place of the wheels add up with the way, which calibration mends.

===============  ====================================================================
``wheels``       `TrackingWheels`, counters that wrap around, travel
``motion``       travel -> motion of the body -> poses; velocity
``stream``       `Odometry` for a control loop
``calibration``  true sizes from a run and a spin, or from a drive with known poses
``heading``      gyroscope and wheels together
``rough``        poses on a drive on which wheels slip and sensors fall silent
===============  ====================================================================
"""

from robocon_course.odometry.calibration import SizePrior, calibrate_wheels, self_calibrate
from robocon_course.odometry.heading import (
    HeadingGains,
    HeadingLog,
    HeadingState,
    estimate_heading,
    fuse_heading,
)
from robocon_course.odometry.motion import (
    body_deltas,
    body_velocity,
    integrate,
    integrate_arcs,
    odometry_update,
)
from robocon_course.odometry.rough import rough_drive_poses
from robocon_course.odometry.stream import Odometry, OdometryState
from robocon_course.odometry.wheels import TrackingWheels, tick_changes, wheel_travel

__all__ = [
    "HeadingGains",
    "HeadingLog",
    "HeadingState",
    "Odometry",
    "OdometryState",
    "SizePrior",
    "TrackingWheels",
    "body_deltas",
    "body_velocity",
    "calibrate_wheels",
    "estimate_heading",
    "fuse_heading",
    "integrate",
    "integrate_arcs",
    "odometry_update",
    "rough_drive_poses",
    "self_calibrate",
    "tick_changes",
    "wheel_travel",
]

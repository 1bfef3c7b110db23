"""Chapter 01: which way is up, and how far has the robot turned?

A gyroscope knows every turn but drifts; an accelerometer knows where up is, but only while nobody
pushes it. Calibrated, and mixed by the Mahony filter, the two give a tilt good to a fraction of a
degree. A magnetometer is left out: motors and servos bend its field by more than it would help.

===============  ===============================================================
``calibration``  bias and scale, from a still log, six rests or slow turns
``attitude``     tilt from gravity, angles, what they are worth
``mahony``       the filter, one step
``estimate``     the filter over time: a stream, or a whole log
``motion``       the same for a rough drive with gaps
``logs``         recorded logs in, angles out (CSV)
``phone``        a phone as IMU, over UDP
===============  ===============================================================
"""

from robocon_course.geometry import GRAVITY
from robocon_course.imu.attitude import (
    attitude_from_accel,
    euler_angles,
    gravity_direction,
    inclination_error,
)
from robocon_course.imu.calibration import (
    AccelerometerCalibration,
    GyroCalibration,
    MovedError,
    calibrate_accelerometer,
    calibrate_gyro,
    fit_ellipsoid,
)
from robocon_course.imu.estimate import AttitudeFilter, AttitudeLog, estimate_attitude
from robocon_course.imu.logs import ImuLog, read_log, write_angles
from robocon_course.imu.mahony import MahonyGains, MahonyState, mahony_step, mahony_update
from robocon_course.imu.motion import attitude_in_motion
from robocon_course.imu.phone import Listener, Sample, listen

__all__ = [
    "GRAVITY",
    "AccelerometerCalibration",
    "AttitudeFilter",
    "AttitudeLog",
    "GyroCalibration",
    "ImuLog",
    "Listener",
    "MahonyGains",
    "MahonyState",
    "MovedError",
    "Sample",
    "attitude_from_accel",
    "attitude_in_motion",
    "calibrate_accelerometer",
    "calibrate_gyro",
    "estimate_attitude",
    "euler_angles",
    "fit_ellipsoid",
    "gravity_direction",
    "inclination_error",
    "listen",
    "mahony_step",
    "mahony_update",
    "read_log",
    "write_angles",
]

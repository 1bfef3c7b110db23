"""Chapter 01: the exercises of the IMU, and how people get them wrong."""

from robocon_course.exercises.imu.attitude import EULER_ANGLES, GRAVITY_DIRECTION, MAHONY_STEP
from robocon_course.exercises.imu.calibration import (
    CALIBRATE_ACCELEROMETER,
    CALIBRATE_GYRO,
    FIT_ELLIPSOID,
)
from robocon_course.exercises.imu.own_world import ATTITUDE_IN_MOTION, OWN_BIAS, OWN_DRIFT
from robocon_course.exercises.model import Chapter

CHAPTER = Chapter(
    number="01",
    topic="imu",
    title="IMU: calibration and the Mahony filter",
    minutes=210,
    needs=("chapter 00", "vectors", "NumPy arrays"),
    exercises=(
        CALIBRATE_GYRO,
        OWN_BIAS,
        CALIBRATE_ACCELEROMETER,
        FIT_ELLIPSOID,
        GRAVITY_DIRECTION,
        MAHONY_STEP,
        EULER_ANGLES,
        OWN_DRIFT,
        ATTITUDE_IN_MOTION,
    ),
)

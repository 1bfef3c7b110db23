"""Chapter 02: the exercises of odometry, and how people get them wrong."""

from robocon_course.exercises.model import Chapter
from robocon_course.exercises.odometry.body import BODY_DELTAS
from robocon_course.exercises.odometry.calibration import CALIBRATE_WHEELS
from robocon_course.exercises.odometry.counters import TICK_CHANGES
from robocon_course.exercises.odometry.own_world import (
    OWN_OFFSET,
    OWN_SQUARE,
    ROUGH_DRIVE_POSES,
)
from robocon_course.exercises.odometry.poses import INTEGRATE
from robocon_course.exercises.odometry.velocity import BODY_VELOCITY
from robocon_course.exercises.odometry.wheels import WHEEL_MATRIX, WHEEL_TRAVEL

CHAPTER = Chapter(
    number="02",
    topic="odometry",
    title="Odometry: three wheels that count",
    minutes=240,
    needs=("chapter 00", "chapter 01 up to the bias", "matrices, NumPy arrays"),
    exercises=(
        TICK_CHANGES,
        WHEEL_TRAVEL,
        WHEEL_MATRIX,
        BODY_DELTAS,
        INTEGRATE,
        BODY_VELOCITY,
        OWN_SQUARE,
        CALIBRATE_WHEELS,
        OWN_OFFSET,
        ROUGH_DRIVE_POSES,
    ),
)

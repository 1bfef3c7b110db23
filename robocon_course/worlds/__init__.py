"""Student number -> seed -> a world of one's own, the same to the bit on every machine.

=============  ====================================================
``student``    student numbers, and draws that belong to one
``imu``        chapter 01: a phone's IMU and its logs
``robot``      one student's robot, not quite as drawn
``swerve``     chapter 03: its modules, a log of them, and a wet floor
``practice``   chapter 05: a cart of one's own, carts and paths nobody has seen
``wheels``     chapter 02: its dead wheels and the logs they recorded
``drive``      drives of that robot in the simulator
``to_area_3``  the drive that it plans and follows by itself
=============  ====================================================
"""

from robocon_course.worlds.drive import (
    DRIVES,
    DriveLog,
    bumps,
    drive_log,
    failures,
    simulated_drive,
)
from robocon_course.worlds.imu import (
    DT,
    LEAN,
    MATCH,
    ImuWorld,
    Rung,
    imu_rungs,
    imu_world,
    own_imu,
    rest_means,
    rough_drive,
)
from robocon_course.worlds.practice import (
    PUBLISHED,
    SOURCE_PATHS,
    PracticeWorld,
    finely,
    practice_world,
    some_cart,
    winding_path,
)
from robocon_course.worlds.robot import own_robot, own_wheels
from robocon_course.worlds.student import Student, generator, student_number
from robocon_course.worlds.swerve import SlipLog, SwerveWorld, slip_log, swerve_world
from robocon_course.worlds.to_area_3 import FieldDrive, calibrated_wheels, field_drive
from robocon_course.worlds.wheels import (
    BITS,
    RUN,
    SPIN,
    SQUARE,
    OdometryWorld,
    RoughDrive,
    WheelLog,
    gyro_of,
    odometry_world,
    random_legs,
    rough_drive_log,
    wheel_log,
)

__all__ = [
    "BITS",
    "DRIVES",
    "DT",
    "LEAN",
    "MATCH",
    "PUBLISHED",
    "RUN",
    "SOURCE_PATHS",
    "SPIN",
    "SQUARE",
    "DriveLog",
    "FieldDrive",
    "ImuWorld",
    "OdometryWorld",
    "PracticeWorld",
    "RoughDrive",
    "Rung",
    "SlipLog",
    "Student",
    "SwerveWorld",
    "WheelLog",
    "bumps",
    "calibrated_wheels",
    "drive_log",
    "failures",
    "field_drive",
    "finely",
    "generator",
    "gyro_of",
    "imu_rungs",
    "imu_world",
    "odometry_world",
    "own_imu",
    "own_robot",
    "own_wheels",
    "practice_world",
    "random_legs",
    "rest_means",
    "rough_drive",
    "rough_drive_log",
    "simulated_drive",
    "slip_log",
    "some_cart",
    "student_number",
    "swerve_world",
    "wheel_log",
    "winding_path",
]

"""Student number -> seed -> a world of one's own, the same to the bit on every machine.

===========  ====================================================
``student``  student numbers, and draws that belong to one
``imu``      chapter 01: a phone's IMU and its logs
``robot``    one student's robot, not quite as drawn
``swerve``   chapter 03: its modules, a log of them, and a wet floor
``wheels``   chapter 02: its dead wheels and the logs they recorded
``ways``     chapter 04: the field with boxes of one's own
``drive``    drives of that robot in the simulator
===========  ====================================================
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
from robocon_course.worlds.robot import own_robot, own_wheels
from robocon_course.worlds.student import Student, generator, student_number
from robocon_course.worlds.swerve import SlipLog, SwerveWorld, slip_log, swerve_world
from robocon_course.worlds.ways import (
    HALF,
    RAMP_TOP,
    WaysWorld,
    boxed_field,
    driving_time,
    passable_field,
    strewn_boxes,
    way_length,
    ways_world,
    widest_half,
    wrong_lengths,
)
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
    "HALF",
    "LEAN",
    "MATCH",
    "RAMP_TOP",
    "RUN",
    "SPIN",
    "SQUARE",
    "DriveLog",
    "ImuWorld",
    "OdometryWorld",
    "RoughDrive",
    "Rung",
    "SlipLog",
    "Student",
    "SwerveWorld",
    "WaysWorld",
    "WheelLog",
    "boxed_field",
    "bumps",
    "drive_log",
    "driving_time",
    "failures",
    "generator",
    "gyro_of",
    "imu_rungs",
    "imu_world",
    "odometry_world",
    "own_imu",
    "own_robot",
    "own_wheels",
    "passable_field",
    "random_legs",
    "rest_means",
    "rough_drive",
    "rough_drive_log",
    "simulated_drive",
    "slip_log",
    "strewn_boxes",
    "student_number",
    "swerve_world",
    "way_length",
    "ways_world",
    "wheel_log",
    "widest_half",
    "wrong_lengths",
]

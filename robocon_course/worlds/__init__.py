"""Student number -> seed -> a world of one's own, the same to the bit on every machine.

===========  ==========================================
``student``  student numbers, and draws that belong to one
``imu``      chapter 01: a phone's IMU and its logs
===========  ==========================================
"""

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
from robocon_course.worlds.student import Student, generator, student_number

__all__ = [
    "DT",
    "LEAN",
    "MATCH",
    "ImuWorld",
    "Rung",
    "Student",
    "generator",
    "imu_rungs",
    "imu_world",
    "own_imu",
    "rest_means",
    "rough_drive",
    "student_number",
]

"""The robot's replaceable parts.

Each part is one function of one chapter. The references stand here by default; an accepted answer
takes the place of the reference of the same name. Chapters to come add their parts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from robocon_course import (
    geometry,
    gridmap,
    imu,
    mission,
    odometry,
    planning,
    swerve,
    tracking,
    vision,
)
from robocon_course.drivetrain import wheel_matrix

Part = Callable[..., Any]


@dataclass(frozen=True)
class Parts:
    """The robot's parts; ``mine`` names those that a student wrote."""

    wrap_angle: Part = geometry.wrap_angle
    calibrate_gyro: Part = imu.calibrate_gyro
    calibrate_accelerometer: Part = imu.calibrate_accelerometer
    fit_ellipsoid: Part = imu.fit_ellipsoid
    gravity_direction: Part = imu.gravity_direction
    mahony_step: Part = imu.mahony_step
    euler_angles: Part = imu.euler_angles
    tick_changes: Part = odometry.tick_changes
    wheel_travel: Part = odometry.wheel_travel
    wheel_matrix: Part = wheel_matrix
    body_deltas: Part = odometry.body_deltas
    integrate: Part = odometry.integrate
    body_velocity: Part = odometry.body_velocity
    calibrate_wheels: Part = odometry.calibrate_wheels
    inflate_square: Part = gridmap.inflate_square
    astar: Part = planning.astar
    shorten_path: Part = planning.shorten_path
    smooth_path: Part = planning.smooth_path
    speed_profile: Part = tracking.speed_profile
    nearest_point: Part = tracking.nearest_point
    pure_pursuit: Part = tracking.pure_pursuit
    pid_step: Part = tracking.pid_step
    decode: Part = vision.decode
    non_max_suppression: Part = vision.non_max_suppression
    bearing_and_range: Part = vision.bearing_and_range
    silo_contents: Part = vision.silo_contents
    next_transition: Part = mission.next_transition
    choose_ball: Part = mission.choose_ball
    choose_silo: Part = mission.choose_silo
    is_stuck: Part = mission.is_stuck
    pose_feedback: Part = swerve.pose_feedback
    field_to_robot: Part = swerve.field_to_robot
    discretize: Part = swerve.discretize
    module_targets: Part = swerve.module_targets
    limit_speeds: Part = swerve.limit_speeds
    shortest_turn: Part = swerve.shortest_turn
    body_twist: Part = swerve.body_twist
    mine: tuple[str, ...] = ()

    @staticmethod
    def names() -> tuple[str, ...]:
        """Names of all parts, in the order in which data meets them."""
        return tuple(f.name for f in fields(Parts) if f.name != "mine")

    def are_the_courses(self, *names: str) -> bool:
        """Whether these parts are the course's own: what they do together may then be compiled."""
        for name in names:  # the robot asks at every tick
            if getattr(self, name) is not getattr(Parts, name):
                return False
        return True

    @property
    def label(self) -> str:
        """Which parts are the student's, in a few words for a figure."""
        if not self.mine:
            return "reference"
        count, whole = len(self.mine), len(self.names())
        return "mine" if count == whole else f"mixed, {count} of {whole} parts mine"

"""The robot's replaceable parts, and the order in which they run: the only room that knows it.

    Observation → reckon → pose ─┐
    bitmap → plan_route → Route ─┴→ follow_step → velocity → module_command → Command

==============  ==========================================================
``parts``       `Parts`: one function for each part, the course's or mine
``sensing``     readings -> attitude, pose; whole logs and step by step
``route``       start and goal -> path and speeds
``following``   path and pose -> velocity on the field
``modules``     velocity on the field -> command for the modules
``pilot``       `Pilot`: drives one route, observation by observation
``walls``       distances to walls -> a better pose
``tracks``      balls, remembered from picture to picture
``sight``       pictures -> balls and silos on the map
``driver``      `Driver`: to one pose after the other
``taking``      the way to a ball, and when the rollers turn
``plays``       what to do in each state of the mission
``autopilot``   `Autopilot`: a whole match, observation by observation
``telemetry``   what it tells on the bus
==============  ==========================================================
"""

from robocon_course.autopilot.autopilot import Autopilot
from robocon_course.autopilot.following import Following, FollowSettings, follow_step
from robocon_course.autopilot.modules import hold, module_command
from robocon_course.autopilot.parts import Part, Parts
from robocon_course.autopilot.pilot import Pilot
from robocon_course.autopilot.route import DriveLimits, Route, plan_route, room_for_body
from robocon_course.autopilot.sensing import (
    COUNTER_BITS,
    HEADINGS,
    Reckoning,
    attitude_angles,
    dead_reckoning,
    lidar_y,
    reckon,
)
from robocon_course.autopilot.sight import Sight
from robocon_course.autopilot.telemetry import Telemetry
from robocon_course.autopilot.walls import Walls, expected_readings, measured_offsets

__all__ = [
    "COUNTER_BITS",
    "HEADINGS",
    "Autopilot",
    "DriveLimits",
    "FollowSettings",
    "Following",
    "Part",
    "Parts",
    "Pilot",
    "Reckoning",
    "Route",
    "Sight",
    "Telemetry",
    "Walls",
    "attitude_angles",
    "dead_reckoning",
    "expected_readings",
    "follow_step",
    "hold",
    "lidar_y",
    "measured_offsets",
    "module_command",
    "plan_route",
    "reckon",
    "room_for_body",
]

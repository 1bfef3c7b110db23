"""The course's three big pictures: the field, the robot, and the robot's program."""

from robocon_course.view._plan import draw_plan
from robocon_course.view._robot import draw_robot
from robocon_course.view._system import draw_system

__all__ = ["draw_plan", "draw_robot", "draw_system"]

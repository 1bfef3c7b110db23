"""What a notebook imports: ``from robocon_course.exercises import begin, check, hint, answer``."""

from robocon_course.exercises.notebook import answer, begin, check, hint, running_as_test, status
from robocon_course.exercises.parts import robot_parts

__all__ = ["answer", "begin", "check", "hint", "robot_parts", "running_as_test", "status"]

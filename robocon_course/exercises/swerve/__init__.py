"""Chapter 03: the exercises of the swerve drive, and how people get them wrong."""

from robocon_course.exercises.model import Chapter
from robocon_course.exercises.swerve.body import BODY_TWIST
from robocon_course.exercises.swerve.commands import DISCRETIZE, FIELD_TO_ROBOT
from robocon_course.exercises.swerve.feedback import POSE_FEEDBACK
from robocon_course.exercises.swerve.kinder import LIMIT_SPEEDS, SHORTEST_TURN
from robocon_course.exercises.swerve.kinematics import MODULE_TARGETS
from robocon_course.exercises.swerve.own_world import FIND_SLIP, OWN_OFFSET, OWN_TURN_RATE

CHAPTER = Chapter(
    number="03",
    topic="swerve",
    title="Swerve: four wheels, one motion",
    minutes=210,
    needs=("chapter 00", "vectors", "least squares from chapter 02"),
    exercises=(
        MODULE_TARGETS,
        FIELD_TO_ROBOT,
        SHORTEST_TURN,
        LIMIT_SPEEDS,
        OWN_TURN_RATE,
        BODY_TWIST,
        OWN_OFFSET,
        DISCRETIZE,
        POSE_FEEDBACK,
        FIND_SLIP,
    ),
)

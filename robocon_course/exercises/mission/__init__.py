"""Chapter 07: the exercises of the mission, and how people get them wrong."""

from robocon_course.exercises.mission.balls import CHOOSE_BALL
from robocon_course.exercises.mission.challenge import MY_STRATEGY
from robocon_course.exercises.mission.listing import NEVER_REACHED, OWN_DEAD_ENDS
from robocon_course.exercises.mission.silos import CHOOSE_SILO
from robocon_course.exercises.mission.states import DEAD_ENDS, NEXT_TRANSITION, REACHABLE
from robocon_course.exercises.mission.watch import IS_STUCK
from robocon_course.exercises.model import Chapter

CHAPTER = Chapter(
    number="07",
    topic="mission",
    title="The match: decide what comes next",
    minutes=210,
    needs=("chapters 00, 05 and 06", "sets, loops over tables"),
    exercises=(
        NEXT_TRANSITION,
        REACHABLE,
        DEAD_ENDS,
        NEVER_REACHED,
        OWN_DEAD_ENDS,
        IS_STUCK,
        CHOOSE_BALL,
        CHOOSE_SILO,
        MY_STRATEGY,
    ),
)

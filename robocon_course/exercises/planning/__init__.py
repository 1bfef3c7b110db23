"""Chapter 04: the exercises of planning, and how people get them wrong."""

from robocon_course.exercises.model import Chapter
from robocon_course.exercises.planning.octile import OCTILE_DISTANCE
from robocon_course.exercises.planning.own_world import OWN_GAP, OWN_LENGTH
from robocon_course.exercises.planning.room import INFLATE_SQUARE
from robocon_course.exercises.planning.search import ASTAR
from robocon_course.exercises.planning.shorter import SHORTEN_PATH
from robocon_course.exercises.planning.smooth import SMOOTH_PATH
from robocon_course.exercises.planning.steps import NEIGHBOURS
from robocon_course.exercises.planning.thinner import THIN_PATH

CHAPTER = Chapter(
    number="04",
    topic="planning",
    title="Planning: the way over the field",
    minutes=240,
    needs=("chapter 00", "Python lists and dictionaries"),
    exercises=(
        INFLATE_SQUARE,
        OCTILE_DISTANCE,
        NEIGHBOURS,
        ASTAR,
        OWN_LENGTH,
        OWN_GAP,
        THIN_PATH,
        SHORTEN_PATH,
        SMOOTH_PATH,
    ),
)

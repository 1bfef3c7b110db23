"""Chapter 05: the exercises of path tracking, and how people get them wrong."""

from robocon_course.exercises.model import Chapter
from robocon_course.exercises.tracking.lookahead import LOOKAHEAD_POINT
from robocon_course.exercises.tracking.nearest import NEAREST_POINT
from robocon_course.exercises.tracking.own_world import OWN_GAIN, OWN_PERIOD, TUNE
from robocon_course.exercises.tracking.pid import PID_STEP
from robocon_course.exercises.tracking.profile import SPEED_PROFILE
from robocon_course.exercises.tracking.pursuit import PURE_PURSUIT
from robocon_course.exercises.tracking.tuning import ZIEGLER_NICHOLS

CHAPTER = Chapter(
    number="05",
    topic="tracking",
    title="Tracking: stay on the path",
    minutes=240,
    needs=("chapters 00 and 04", "arctangent, derivative, integral"),
    exercises=(
        PID_STEP,
        ZIEGLER_NICHOLS,
        OWN_GAIN,
        OWN_PERIOD,
        NEAREST_POINT,
        LOOKAHEAD_POINT,
        PURE_PURSUIT,
        SPEED_PROFILE,
        TUNE,
    ),
)

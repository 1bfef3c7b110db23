"""Chapter 06: the exercises of vision, and how people get them wrong."""

from robocon_course.exercises.model import Chapter
from robocon_course.exercises.vision.boxes import BOX_IOU, XYXY_FROM_YOLO
from robocon_course.exercises.vision.challenge import FIND_BALLS
from robocon_course.exercises.vision.head import DECODE
from robocon_course.exercises.vision.precision import AVERAGE_PRECISION, OWN_THRESHOLD
from robocon_course.exercises.vision.ranging import BEARING_AND_RANGE
from robocon_course.exercises.vision.silos import SILO_CONTENTS
from robocon_course.exercises.vision.suppression import NON_MAX_SUPPRESSION

CHAPTER = Chapter(
    number="06",
    topic="vision",
    title="Vision: eyes that are trained",
    minutes=240,
    needs=("chapter 00", "arrays of numpy", "sine and arctangent"),
    exercises=(
        XYXY_FROM_YOLO,
        BOX_IOU,
        DECODE,
        NON_MAX_SUPPRESSION,
        AVERAGE_PRECISION,
        OWN_THRESHOLD,
        BEARING_AND_RANGE,
        SILO_CONTENTS,
        FIND_BALLS,
    ),
)

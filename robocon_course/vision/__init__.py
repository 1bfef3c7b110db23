"""What the camera sees: pictures made and looked at, networks trained and run.

=============  ==================================================================
``classes``    what is told apart
``camera``     points to pixels, pixels to rays
``scene``      what stands before the camera
``paint``      colours and textures
``venue``      halls, benches, silos, balls: painted and lit anew each time
``shots``      which pictures are taken
``render``     what each pixel sees
``shading``    how bright it is there
``film``       from light to a picture
``pictures``   a picture and its boxes, by seed and number
``dataset``    thousands of them on disk
``inspection`` what is wrong with a data set
``sheet``      how it looks
``training``   networks from data sets (needs the extra "vision")
``trainer``    what it changes in Ultralytics
``onnx_file``  a trained network as a file
``curves``     what a training writes after each epoch
``evaluation`` how good a network is on a data set
``reading``    what goes into a network, and what comes out
``detection``  networks run on pictures
``metrics``    how good they are
``locate``     from boxes to bearings, ranges, contents
``colour``     the older way, without a network
=============  ==================================================================

Loaded here is only what reads numbers; who makes pictures or trains imports its file by name.
"""

from robocon_course.vision.camera import Camera, camera_pose
from robocon_course.vision.classes import BALLS, CLASSES, MIN_SCORE, SILOS
from robocon_course.vision.colour import heading_from_landmarks, largest_blob
from robocon_course.vision.detection import (
    Detections,
    Detector,
    WeightsError,
    decode,
    find_balls,
    letterbox,
    load_detector,
    non_max_suppression,
)
from robocon_course.vision.locate import (
    Sighting,
    bearing_and_range,
    locate_ball,
    nearest_own_ball,
    on_floor,
    silo_contents,
)
from robocon_course.vision.metrics import (
    average_precision,
    average_precisions,
    box_iou,
    confusion_matrix,
    match_detections,
    precision_recall,
    score_pictures,
    xyxy_from_yolo,
)

__all__ = [
    "BALLS",
    "CLASSES",
    "MIN_SCORE",
    "SILOS",
    "Camera",
    "Detections",
    "Detector",
    "Sighting",
    "WeightsError",
    "average_precision",
    "average_precisions",
    "bearing_and_range",
    "box_iou",
    "camera_pose",
    "confusion_matrix",
    "decode",
    "find_balls",
    "heading_from_landmarks",
    "largest_blob",
    "letterbox",
    "load_detector",
    "locate_ball",
    "match_detections",
    "nearest_own_ball",
    "non_max_suppression",
    "on_floor",
    "precision_recall",
    "score_pictures",
    "silo_contents",
    "xyxy_from_yolo",
]

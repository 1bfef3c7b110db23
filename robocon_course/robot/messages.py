"""What is told on the bus. Names and meaning follow ROS 2's own messages, one line to a topic.

======================  ==================  =====================================================
topic                   message             who tells it
======================  ==================  =====================================================
``/observation``        `Observation`       the robot: all readings of one moment
``/command``            `Command`           the autopilot, or the stick
``/odom``               `PoseStamped`       the autopilot: where it believes to be
``/ground_truth``       `PoseStamped`       the simulator alone: where it is
``/plan``               `Path`              the autopilot, whenever it plans
``/scan``               `LaserScan`         the robot's LiDARs
``/camera/image``       `Image`             the camera
``/camera/detections``  `Detection2DArray`  what was found in it
``/silos``              `Silos`             the autopilot: what it believes they hold
``/mission/state``      `State`             the mission, whenever its state changes
``/rosout``             `Log`               everybody
``/score``              `Score`             the referee
``/cmd_vel``            `Twist`             the operator's stick
``/operator``           `Button`            the operator's buttons
======================  ==================  =====================================================

Times are seconds on the robot's clock. Arrays are never changed after they were told.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray


class PoseStamped(NamedTuple):
    """A pose; geometry_msgs/PoseStamped.

    Attributes
    ----------
    time : float  [s]
    pose : ndarray, shape (3,)  [m, m, rad; map]
    """

    time: float
    pose: FloatArray


class Path(NamedTuple):
    """A way to drive; nav_msgs/Path.

    Attributes
    ----------
    time : float  [s]
    xy : ndarray, shape (n, 2)  [m, map]
    """

    time: float
    xy: FloatArray


class LaserScan(NamedTuple):
    """Four beams; sensor_msgs/LaserScan.

    Attributes
    ----------
    time : float  [s]
    angles : ndarray, shape (n,)  [rad, base]
    ranges : ndarray, shape (n,)  [m]
        0 where the sensor does not trust itself.
    """

    time: float
    angles: FloatArray
    ranges: FloatArray


class Image(NamedTuple):
    """A picture; sensor_msgs/Image.

    Attributes
    ----------
    time : float  [s]
    image_bgr : ndarray of uint8, shape (h, w, 3)
    """

    time: float
    image_bgr: NDArray[np.uint8]


class Detection2DArray(NamedTuple):
    """What was found in a picture; vision_msgs/Detection2DArray.

    Attributes
    ----------
    time : float  [s]
        Of the picture.
    kind : str
        ``"ball"`` or ``"silo"``.
    boxes : ndarray, shape (n, 4)  [pixels]
        Left, top, right, bottom.
    scores : ndarray, shape (n,)
    labels : tuple of str
    """

    time: float
    kind: str
    boxes: FloatArray
    scores: FloatArray
    labels: tuple[str, ...]


class Silos(NamedTuple):
    """What the five silos are believed to hold.

    Attributes
    ----------
    time : float  [s]
    fillings : tuple of str
        From silo 1 to 5, each from bottom to top, such as ``"RB"``.
    """

    time: float
    fillings: tuple[str, ...]


class State(NamedTuple):
    """What the mission does now.

    Attributes
    ----------
    time : float  [s]
    name : str
    reason : str
        Why it went there.
    """

    time: float
    name: str
    reason: str


class Log(NamedTuple):
    """A line for the operator; rcl_interfaces/Log.

    Attributes
    ----------
    time : float  [s]
    level : str
        ``"info"``, ``"warning"`` or ``"error"``.
    text : str
    """

    time: float
    level: str
    text: str


class Score(NamedTuple):
    """How the match stands.

    Attributes
    ----------
    time : float  [s]
    own, theirs : int
        Points.
    left : float  [s]
        Until the end.
    winner : str
        ``""`` while it is played; ``"own"``, ``"theirs"`` or ``"nobody"``.
    reason : str
        Why it ended.
    """

    time: float
    own: int
    theirs: int
    left: float
    winner: str = ""
    reason: str = ""


class Twist(NamedTuple):
    """Where the stick points; geometry_msgs/Twist.

    Attributes
    ----------
    vx, vy, omega : float  [m/s, m/s, rad/s; base]
    """

    vx: float
    vy: float
    omega: float


class Button(NamedTuple):
    """A button of the operator's screen.

    Attributes
    ----------
    name : str
        ``"start"``, ``"stop"``, ``"retry"``, ``"manual"``, ``"colour"``, ``"side"``, ``"intake"``,
        ``"release"``, ``"pan"`` or ``"tilt"``. The crew's own, for a log to be replayed:
        ``"set_up"`` (see `worlds.match.new_pilot`), ``"placed"`` (x, y, heading and how long the
        robot has to wait), and a ``"start"`` that says how much of that wait is left.
    value : str or float
        What was chosen, where there is a choice.
    """

    name: str
    value: str | float = ""

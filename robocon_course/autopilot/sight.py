"""From boxes in a picture to balls and silos on the map, remembered from picture to picture."""

from __future__ import annotations

from collections import deque
from math import asin, atan2, cos, hypot, isfinite, pi, remainder, sin
from typing import NamedTuple

import numpy as np

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.autopilot.parts import Parts
from robocon_course.autopilot.tracks import SAME, Spot, Track, matched
from robocon_course.field.standing import standing
from robocon_course.mission import SeenBall
from robocon_course.robot import MODULES, SIDE, Frame
from robocon_course.vision import CLASSES, SILOS, Camera, Detections, Sighting, load_detector
from robocon_course.vision.camera import camera_pose
from robocon_course.vision.locate import bearing_and_range, both_rulers, on_floor

CAMERA = Camera()
_RADIUS = 0.5 * field.BALL_DIAMETER
LOW = (_RADIUS, field.STORAGE_ZONE.y0 + _RADIUS)
HIGH = (field.EDGE - _RADIUS, field.SIZE - _RADIUS)
"""No ball's middle lies nearer to a wall of Area 3 and the Storage Zone [m, map]."""
MEMORY = 60
"""So many poses are remembered, to know where a picture was taken."""
UNPLACED = 0.1
"""A picture so far in time from any known pose says nothing of places [s]."""
LEAST_SIDE = 0.5
"""Of a box [pixels]."""
LEAST_SIGMA = 0.01
"""No ball's place is known better than this [m]."""
RANGE = (0.12, 4.2)
"""Balls nearer or farther than this are not looked for [m]."""
VIEW = 0.46
"""Half of the camera's view in which a ball is expected to be found [rad]."""
UPRIGHT = 0.33
"""And half of its view from top to bottom [rad]."""
SURE = 2
"""So often seen, a ball is believed."""
UNSEEN = 15.0
"""A silo's last change may lie so far back [s]; nobody looks away for longer."""
READINGS = 5
"""The last so many readings of a silo decide what it holds."""


class View(NamedTuple):
    """From where a picture was taken.

    Attributes
    ----------
    x, y : float  [m, map]
        Of the lens.
    height : float  [m]
        Of the lens above the ground under the stage.
    heading : float  [rad, map]
        Where the camera looked.
    tilt : float  [rad]
        How far down, the slope under the robot included.
    """

    x: float
    y: float
    height: float
    heading: float
    tilt: float


def view_of(pose: FloatArray, frame: Frame) -> View:
    """From where a frame was taken, given the robot's pose at that time.

    Parameters
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
    frame : Frame

    Returns
    -------
    View
    """
    rise_x, rise_y, height = standing(pose, MODULES).tolist()
    T = camera_pose(pose, height, pan=frame.pan, tilt=frame.tilt, rise=(rise_x, rise_y))
    x, y, z = T[:3, 3].tolist()
    ahead, left, up = T[:3, 2].tolist()
    return View(x, y, z, atan2(left, ahead), asin(-up))


class Sight:
    """What the camera has told so far.

    Parameters
    ----------
    parts : Parts
        ``bearing_and_range``, ``decode``, ``non_max_suppression`` and ``silo_contents`` are used.
    team : {"red", "blue"}

    Attributes
    ----------
    tracks : list of Track
    silos : list of str
        What each is believed to hold, from bottom to top.
    seen_silos : list of float  [s]
        When each was seen last.
    their_balls : list of float  [s]
        About when the other team put each of its balls that was noticed.
    frames : int
        Pictures looked at.
    last : float  [s]
        When the last picture that showed anything at all was taken.
    found : tuple of (str, Detections) or None
        What the last picture showed, for a screen.
    """

    def __init__(self, parts: Parts, team: str = "red") -> None:
        self.parts = parts
        self._theirs = "B" if team == "red" else "R"
        self.their_balls: list[float] = []
        self.tracks: list[Track] = []
        self.silos = [""] * len(field.SILOS)
        self.seen_silos = [-np.inf] * len(field.SILOS)
        self.frames, self.last = 0, -np.inf
        self.found: tuple[str, Detections] | None = None
        self._poses: deque[tuple[float, FloatArray]] = deque(maxlen=MEMORY)
        self._read: list[deque[str]] = [deque(maxlen=READINGS) for _ in field.SILOS]
        self._detectors: dict[str, object] = {}

    def remember(self, time: float, pose: FloatArray) -> None:
        """Where the robot was at a time [s]."""
        self._poses.append((time, pose))

    def forget_balls(self) -> None:
        """Nothing is known of the balls any more."""
        self.tracks = []

    @property
    def balls(self) -> list[SeenBall]:
        """The balls that are believed."""
        return [track.ball for track in self.tracks if track.hits >= SURE]

    def sees(self, ball: SeenBall) -> bool:
        """Whether a ball of that colour was found there in the last picture of the place."""
        return any(
            track.misses == 0
            and track.ball.colour == ball.colour
            and hypot(track.x - ball.x, track.y - ball.y) < SAME
            for track in self.tracks
        )

    def look(self, frame: Frame, kind: str) -> None:
        """Take in one picture.

        Parameters
        ----------
        frame : Frame
        kind : {"ball", "silo"}
            Which network looks at it.
        """
        if not self._poses or not all(map(isfinite, (frame.time, frame.pan, frame.tilt))):
            return
        time, pose = min(self._poses, key=lambda known: abs(known[0] - frame.time))
        if abs(time - frame.time) > UNPLACED:
            return
        found = _possible(self._detections(frame, kind), kind)
        self.frames += 1
        self.found = (kind, found)
        if len(found.scores):
            self.last = frame.time
        view = view_of(pose, frame)
        if kind == "ball":
            self._see_balls(view, found, pose)
        else:
            self._see_silos(view, found, frame.time)

    def other_colours(self, team: str) -> list[SeenBall]:
        """All balls that are not the team's, those that were seen only once among them."""
        return [ball for ball in (track.ball for track in self.tracks) if ball.colour != team]

    def stored(self, silo: int, letter: str) -> None:
        """The robot put a ball into a silo itself."""
        if len(self.silos[silo]) < field.SILO_CAPACITY:
            self.silos[silo] += letter
            self._read[silo].clear()

    # --- inside -----------------------------------------------------------------------------------

    def _detections(self, frame: Frame, kind: str) -> Detections:
        if frame.image_bgr is None:
            return frame.found.get(kind, NOTHING)
        if kind not in self._detectors:
            self._detectors[kind] = load_detector(kind).with_parts(
                self.parts.decode, self.parts.non_max_suppression
            )
        return self._detectors[kind].detect(frame.image_bgr)

    def _see_balls(self, view: View, found: Detections, pose: FloatArray) -> None:
        spots = []
        floor = field.STORAGE_ZONE.height
        for box, score, number in zip(found.boxes, found.scores, found.class_ids, strict=True):
            sighting = self._located(box, view, floor)
            if sighting is None or not RANGE[0] < sighting.range < RANGE[1]:
                continue
            angle = view.heading + sighting.bearing
            x, y = view.x + sighting.range * cos(angle), view.y + sighting.range * sin(angle)
            if field.SIDE_SLOPE.x0 < x:  # on the slope, or beyond it on the platform: higher
                height = min(float(field.floor_height(min(x, 3.3), 10.0)), 0.25)
                sighting = self._located(box, view, height) or sighting
                x, y = view.x + sighting.range * cos(angle), view.y + sighting.range * sin(angle)
            x, y = min(max(x, LOW[0]), HIGH[0]), min(max(y, LOW[1]), HIGH[1])
            variance = sighting.range_sigma**2 + LEAST_SIGMA**2
            spots.append(Spot(x, y, variance, int(number), float(score)))
        tracks = matched(self.tracks, spots, lambda track: _expected_in(view, track))
        self.tracks = [track for track in tracks if not _under(pose, track)]

    def _located(self, box: FloatArray, view: View, floor: float) -> Sighting | None:
        """A ball on a floor of that height, by its size and by the floor together."""
        left, top, right, bottom = (float(side) for side in box)
        if not (right > left and bottom > top):
            return None
        size = Sighting(*self.parts.bearing_and_range(box, CAMERA, view.tilt))
        if not size.range_sigma > 0.0:  # a student's part says where, and not how surely
            sure = bearing_and_range(box, CAMERA, view.tilt)
            size = Sighting(size.bearing, size.range, sure.bearing_sigma, sure.range_sigma)
        ground = on_floor(box, CAMERA, view.tilt, view.height - floor)
        return both_rulers(size, ground)

    def _see_silos(self, view: View, found: Detections, time: float) -> None:
        groups: dict[int, list[int]] = {}
        for k, (left, top, right, bottom) in enumerate(found.boxes.tolist()):
            ray = CAMERA.rays([[0.5 * (left + right), 0.5 * (top + bottom)]])[0]
            angle = view.heading - atan2(ray[0], ray[2])
            if abs(remainder(angle, 2 * pi)) > 1.3:
                continue
            y = view.y + (field.SILOS[0][0] - view.x) * np.tan(angle)
            gaps = [abs(y - silo[1]) for silo in field.SILOS]
            silo = int(np.argmin(gaps))
            if gaps[silo] < 0.3:
                groups.setdefault(silo, []).append(k)
        for silo, members in groups.items():
            chosen = Detections(*(column[members] for column in found))
            told = self.parts.silo_contents(chosen)
            if len(told) and told[0] in SILOS:
                self._read_silo(silo, str(told[0]).replace("empty", ""), time)

    def _read_silo(self, silo: int, filling: str, time: float) -> None:
        """Balls never leave a silo: fewer than before is a mistake, unless it is said often."""
        before, self.seen_silos[silo] = self.seen_silos[silo], time
        read = self._read[silo]
        read.append(filling)
        same = sum(one == filling for one in read)
        grown = filling.startswith(self.silos[silo]) and len(filling) > len(self.silos[silo])
        if (grown and same >= 2) or same >= 4:
            new = filling.count(self._theirs) - self.silos[silo].count(self._theirs)
            if new > 0:  # some time since it was seen last
                since = max(before, time - UNSEEN, *self.their_balls[-1:])
                self.their_balls += [0.5 * (since + time)] * new
            self.silos[silo] = filling


def _possible(found: Detections, kind: str) -> Detections:
    """Without boxes that no picture can hold, and classes that no network has."""
    boxes = np.asarray(found.boxes, float).reshape(-1, 4)
    size = (CAMERA.width, CAMERA.height)
    inside = ((boxes > (-size[0], -size[1]) * 2) & (boxes < (2 * size[0], 2 * size[1]) * 2)).all(1)
    boxes = np.where(inside[:, None], boxes, 0.0)
    inside &= (boxes[:, 2:] - boxes[:, :2] > LEAST_SIDE).all(1)
    inside &= (found.class_ids >= 0) & (found.class_ids < len(CLASSES[kind]))
    return found if inside.all() else Detections(*(column[inside] for column in found))


def _expected_in(view: View, track: Track) -> bool:
    """Whether a ball should be found in a picture taken from there."""
    far = hypot(track.x - view.x, track.y - view.y)
    bearing = remainder(atan2(track.y - view.y, track.x - view.x) - view.heading, 2 * pi)
    down = atan2(view.height - field.STORAGE_ZONE.height - 0.5 * field.BALL_DIAMETER, far)
    return abs(bearing) < VIEW and far < 2.5 and abs(down - view.tilt) < UPRIGHT


def _under(pose: FloatArray, track: Track) -> bool:
    """Whether the robot stands where a ball was: it pushed it away."""
    dx, dy, c, s = track.x - pose[0], track.y - pose[1], cos(pose[2]), sin(pose[2])
    return max(abs(c * dx + s * dy), abs(c * dy - s * dx)) < 0.5 * SIDE


NOTHING = Detections(np.empty((0, 4), np.float32), np.empty(0, np.float32), np.empty(0, np.int64))

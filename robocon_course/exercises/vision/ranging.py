"""Bearing and range of a ball from its box, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, sin, tan

import numpy as np

from robocon_course import vision
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.vision import Camera, Sighting
from robocon_course.worlds import Student

RADIUS = 0.095
JUDGED = {"bearing": 1e-6, "range": 1e-6}


def _outline(camera: Camera, x: float, y: float, z: float) -> np.ndarray:
    """Box of a ball in front of a camera, to a tenth of a pixel."""
    across, down = np.arctan2(x, z), np.arctan2(y, z)
    wide, high = np.arcsin(RADIUS / np.hypot(x, z)), np.arcsin(RADIUS / np.hypot(y, z))
    ends = [np.tan([across - wide, across + wide]), np.tan([down - high, down + high])]
    middle = camera.focal * np.array([np.mean(ends[0]), np.mean(ends[1])]) + camera.centre
    half = camera.focal * np.array([np.ptp(ends[0]), np.ptp(ends[1])]) / 2
    return np.round(np.r_[middle - half, middle + half], 1)


def _range_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    plain = Camera(320, 240, 300.0, 0.0)
    rows = [
        ("straight ahead, 1 m away", (0.0, 0.0, 1.0), plain, 0.0),
        ("to the right", (0.4, 0.1, 1.2), plain, 0.0),
        ("to the left, and the camera looks down", (-0.3, 0.0, 1.0), plain, 0.3),
    ]
    cases = [_case(what, _outline(camera, *at), camera, tilt) for what, at, camera, tilt in rows]
    box = _outline(plain, 0.3, 0.1, 1.0)
    half, low = box.copy(), box.copy()
    half[0] = round((box[0] + box[2]) / 2, 1)
    low[3] = round(box[3] - 0.3 * (box[3] - box[1]), 1)
    cases.append(_case("its left half is hidden", half, plain, 0.1))
    cases.append(_case("its lower part is hidden", low, plain, 0.1))
    for _ in range(3):
        camera = Camera(320, 240, round(rng.uniform(220.0, 330.0), 1), 0.0)
        at = rng.uniform((-0.5, -0.1, 0.8), (0.5, 0.3, 2.5))
        tilt = round(rng.uniform(0.0, 0.5), 2)
        cases.append(_case("any ball, any camera", _outline(camera, *at), camera, tilt))
    return cases


def _case(what: str, box: np.ndarray, camera: Camera, tilt: float) -> Case:
    return Case(what, (box, camera, tilt), "", dict(JUDGED))


def _sight(
    *,
    radius: float = RADIUS,
    side: Callable[[float, float], float] = min,
    angle: Callable[[float], float] = lambda half: sin(half),
    bearing: Callable[[float, float], float] = lambda left, ahead: atan2(left, ahead),
    tilted: float = 1.0,
    level: bool = True,
    centre: bool = True,
    unit: float = 1.0,
) -> Callable[..., Sighting]:
    """The sighting with one part wrong."""

    def function(box: np.ndarray, camera: Camera, tilt: float) -> Sighting:
        flat = (np.asarray(box, float).reshape(2, 2) - (camera.centre if centre else (0, 0))) / (
            camera.focal
        )
        looks = np.arctan(flat)
        middle, half = looks.mean(axis=0), np.diff(looks, axis=0)[0] / 2
        depths = [radius / angle(h) * cos(m) for h, m in zip(half, middle, strict=True)]
        depth, t = side(*depths), tilted * tilt
        x, y = tan(middle[0]), tan(middle[1])
        ahead, left = cos(t) - y * sin(t), -x
        far = hypot(ahead, left) if level else float(np.sqrt(1.0 + x * x + y * y))
        return Sighting(bearing(left, ahead) * unit, depth * far, 0.0, 0.0)

    return function


def _flat_disc(box: np.ndarray, camera: Camera, tilt: float) -> Sighting:
    """The pinhole's formula for a disc of the ball's size."""
    left, top, right, bottom = np.asarray(box, float)
    depth = 2 * RADIUS * camera.focal / max(right - left, bottom - top)
    x = ((left + right) / 2 - camera.centre[0]) / camera.focal
    y = ((top + bottom) / 2 - camera.centre[1]) / camera.focal
    ahead = cos(tilt) - y * sin(tilt)
    return Sighting(atan2(-x, ahead), depth * hypot(ahead, x), 0.0, 0.0)


BEARING_AND_RANGE = Exercise(
    id="vision.bearing_and_range",
    title="Where is the ball?",
    points=3,
    reference=vision.bearing_and_range,
    cases=_range_cases,
    shortcuts=(
        "robocon_course.vision.locate.locate_ball",
        "robocon_course.vision.locate._look",
        "robocon_course.vision.locate._levelled",
    ),
    hints=(
        "An edge at pixel u is seen under the angle arctan((u − middle) / focal). Do that for left "
        "and right, and for top and bottom; camera.centre is the picture's middle.",
        "The ball lies halfway between its edges: a = (a_left + a_right) / 2. Half of their "
        "difference is h with sin h = 0.095 / distance, seen from above.",
        "Depth along the camera's axis: 0.095 / sin h · cos a. Once by width, once by height: the "
        "smaller one counts, because what hides a part makes the ball look farther away.",
        "With x = tan(a) across and y = tan(b) down: ahead = cos tilt − y sin tilt, left = −x. "
        "bearing = atan2(left, ahead), range = depth · hypot(ahead, left).",
    ),
    mistakes=(
        Mistake(
            "right is positive",
            "The sign of the bearing is turned round: to the left is positive (REP-103), and a "
            "larger pixel number lies to the right.",
            _sight(bearing=lambda left, ahead: -atan2(left, ahead)),
        ),
        Mistake(
            "degrees",
            "The bearing is in degrees. Angles here are in radians.",
            _sight(unit=180.0 / np.pi),
        ),
        Mistake(
            "diameter for radius",
            "The range is twice too long: half the angle belongs to the radius, 0.095 m.",
            _sight(radius=2 * RADIUS),
        ),
        Mistake(
            "whole angle",
            "The range is about half: the radius belongs to half the angle between the edges.",
            _sight(angle=lambda half: sin(2 * half)),
        ),
        Mistake(
            "tangent",
            "The range comes from the tangent of half the angle. The look at an edge touches the "
            "ball: the right angle is at the ball, so it is the sine.",
            _sight(angle=tan),
        ),
        Mistake(
            "a flat disc",
            "0.19 f / width would be right for a flat disc that faces the lens. The looks touch a "
            "ball before its middle, and aside it appears stretched: take the angles of its edges.",
            _flat_disc,
        ),
        Mistake(
            "the farther of two",
            "Of width and height this believes the one that looks smaller. A part may be hidden: "
            "believe the nearer.",
            _sight(side=max),
        ),
        Mistake(
            "width only",
            "Only the width is used. Where the left half is hidden the ball looks twice as far "
            "away: take the nearer of width and height.",
            _sight(side=lambda by_width, by_height: by_width),
        ),
        Mistake(
            "height only",
            "Only the height is used. Where the lower part is hidden the ball looks too far away: "
            "take the nearer of width and height.",
            _sight(side=lambda by_width, by_height: by_height),
        ),
        Mistake(
            "mean of two",
            "This takes the mean by width and by height. Where a part is hidden one of them is "
            "wrong: believe the nearer.",
            _sight(side=lambda by_width, by_height: (by_width + by_height) / 2),
        ),
        Mistake(
            "tilt forgotten",
            "The tilt is not used: a camera that looks down sees a ball on the floor higher in the "
            "picture.",
            _sight(tilted=0.0),
        ),
        Mistake(
            "tilt the wrong way",
            "The tilt is turned the wrong way: it looks down, so what is in the middle of the "
            "picture lies lower than the lens.",
            _sight(tilted=-1.0),
        ),
        Mistake(
            "distance instead of range",
            "This is the distance to the ball through the air. The range is measured along the "
            "floor.",
            _sight(level=False),
        ),
        Mistake(
            "corner of the picture",
            "Pixels are counted from the corner; angles are measured from the picture's middle: "
            "subtract camera.centre.",
            _sight(centre=False),
        ),
    ),
)

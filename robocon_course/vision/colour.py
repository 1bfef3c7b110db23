"""Finding balls by colour alone: thresholds on hue, the largest blob, hysteresis, no network.

Fast and easily explained, and blind where the light changes the colour: the lesson shows where.

Source: colour tracking of a robot's landmarks, ITS Surabaya, 2015; four balls in the corners of
a field, of which the pair that is seen tells the heading.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.vision.reading import as_picture


class Window(NamedTuple):
    """Which pixels count as a colour. Hues in degrees, from `low` to `high`, over 360 if need be.

    Attributes
    ----------
    low, high : float  [deg]
    saturation, value : float
        At least so much, 0 to 1, for a pixel that starts a blob.
    loose_saturation, loose_value : float
        At least so much for one that only continues it.
    """

    low: float
    high: float
    saturation: float = 0.5
    value: float = 0.25
    loose_saturation: float = 0.3
    loose_value: float = 0.12


COLOURS = {
    "blue": Window(205.0, 235.0),
    "purple": Window(250.0, 318.0, saturation=0.3, loose_saturation=0.2),
    "red": Window(338.0, 368.0),
    "green": Window(100.0, 160.0),
    "orange": Window(18.0, 42.0, saturation=0.6),
}
"""Windows of the contest's balls, and of the landmarks of the source."""
LOOSER = 8.0
"""How many degrees of hue the loose window is wider to each side [deg]."""

HEADINGS = {
    frozenset({"green", "blue"}): 0,
    frozenset({"orange", "green"}): 90,
    frozenset({"red", "orange"}): 180,
    frozenset({"blue", "red"}): 270,
}
"""Heading [deg] by the pair of landmarks in view; source: chapter 4."""


class Blob(NamedTuple):
    """A connected patch of one colour.

    Attributes
    ----------
    box : ndarray, shape (4,)  [pixels]
        Left, top, right, bottom.
    centre : ndarray, shape (2,)  [pixels]
        Mean of its pixels.
    area : int  [pixels]
    """

    box: FloatArray
    centre: FloatArray
    area: int


def colour_mask(image_bgr: NDArray[np.uint8], window: Window) -> NDArray[np.bool_]:
    """Pixels of a colour, with hysteresis: loose ones count where they touch a strict one's patch.

    Parameters
    ----------
    image_bgr : ndarray of uint8, shape (h, w, 3)
    window : Window

    Returns
    -------
    ndarray of bool, shape (h, w)
    """
    import cv2

    hsv = cv2.cvtColor(as_picture(image_bgr).astype(np.float32) / 255.0, cv2.COLOR_BGR2HSV)
    strict = _within(hsv, window.low, window.high, window.saturation, window.value)
    loose = _within(
        hsv, window.low - LOOSER, window.high + LOOSER, window.loose_saturation, window.loose_value
    )
    _, patches = cv2.connectedComponents(loose.astype(np.uint8))
    started = np.unique(patches[strict & loose])
    return np.isin(patches, started[started > 0])


def _within(
    hsv: NDArray[np.float32], low: float, high: float, saturation: float, value: float
) -> NDArray[np.bool_]:
    hue = (hsv[..., 0] - low) % 360.0 <= high - low
    return hue & (hsv[..., 1] >= saturation) & (hsv[..., 2] >= value)


def largest_blob(
    image_bgr: NDArray[np.uint8],
    colour: str,
    *,
    near: FloatArray | None = None,
    least_area: int = 20,
) -> Blob | None:
    """The largest patch of a colour, or the one that is being followed.

    Parameters
    ----------
    image_bgr : ndarray of uint8, shape (h, w, 3)
    colour : str
        A key of `COLOURS`.
    near : ndarray, shape (2,), optional  [pixels]
        Where the blob was in the picture before. A blob that covers this place is kept even if
        another has grown larger, unless that one is twice as large: the eye does not jump.
    least_area : int  [pixels]

    Returns
    -------
    Blob or None

    Raises
    ------
    ValueError
        A colour that has no window, or no picture.
    """
    import cv2

    if colour not in COLOURS:
        raise ValueError(f"colour: expected one of {', '.join(COLOURS)}, got {colour!r}")
    mask = colour_mask(image_bgr, COLOURS[colour]).astype(np.uint8)
    count, _, stats, middles = cv2.connectedComponentsWithStats(mask)
    found = [
        Blob(np.array([x, y, x + w, y + h], float), middles[k], int(area))
        for k, (x, y, w, h, area) in enumerate(stats[:count])
        if k > 0 and area >= least_area
    ]
    if not found:
        return None
    largest = max(found, key=lambda blob: blob.area)
    for blob in found if near is not None else ():
        covers = (blob.box[:2] <= near).all() and (near <= blob.box[2:]).all()
        if covers and 2 * blob.area > largest.area:
            return blob
    return largest


def heading_from_landmarks(seen: Iterable[str]) -> int | None:
    """The heading that a pair of landmarks in view means.

    Parameters
    ----------
    seen : iterable of str
        Colours of the landmarks in the picture.

    Returns
    -------
    int or None  [deg]
        0, 90, 180 or 270; None unless exactly one of the four pairs is in view.
    """
    return HEADINGS.get(frozenset(seen))

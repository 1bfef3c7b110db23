"""The camera's picture with what was found in it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robocon_course.view.dashboard.inbox import Inbox
from robocon_course.view.dashboard.markup import QUIET, data_uri, escaped, head, number
from robocon_course.vision.camera import Camera
from robocon_course.vision.sheet import COLOURS, OTHER

WIDTH = 360
"""Of the picture on the screen [pixels]."""
QUALITY = 70
LATE = 0.5
"""Detections this far from the picture's time belong to another one [s]."""


class Sight:
    """Draws a picture once, however often it is asked for."""

    def __init__(self) -> None:
        self._drawn: tuple[tuple[int, ...], str] = ((), "")
        self._keep: tuple[Any, ...] = ()

    def draw(self, inbox: Inbox) -> str:
        """The last picture with its boxes and their words, as HTML.

        Parameters
        ----------
        inbox : Inbox

        Returns
        -------
        str
        """
        image, found = inbox.latest.get("/camera/image"), list(inbox.found.values())
        # Where no picture is sent, the latest that was found stands for its time.
        now = max((one.time for one in found), default=0.0) if image is None else image.time
        shown = tuple(one for one in found if _together(now, one.time))
        # What is drawn is kept too: its place in memory names it as long as it lives.
        keep = (image, *shown)
        name = tuple(map(id, keep))
        if name != self._drawn[0]:
            self._drawn, self._keep = (name, _page(image, shown)), keep
        return self._drawn[1]


def _together(one: float, other: float) -> bool:
    return abs(one - other) <= LATE


def _page(image: Any, found: tuple[Any, ...]) -> str:
    words = "; ".join(map(_words, found)) or "nothing was looked for"
    if image is None and not found:
        blank = f"background:#E9ECEF;color:{QUIET};height:240px;text-align:center;line-height:240px"
        return head("Camera") + f'<div style="{blank}">no picture yet</div>'
    if image is None:
        camera = Camera()
        pixels = np.full((camera.height, camera.width, 3), 90, np.uint8)
        words += " (no picture was sent)"
    else:
        pixels = np.asarray(image.image_bgr)
    source = data_uri(photograph(pixels, found), "jpeg")
    frame = "display:block;width:100%;height:240px;object-fit:contain;background:#222"
    alt = f"Camera: {escaped(words)}"
    return head("Camera") + f'<img style="{frame}" alt="{alt}" src="{source}"><div>{words}</div>'


def _words(found: Any) -> str:
    """What was found, counted: ``2 red, 1 blue``; silos from left to right."""
    labels = [str(label) for label in found.labels]
    if found.kind == "silo":
        order = np.argsort(np.asarray(found.boxes, float).reshape(-1, 4)[:, 0])
        listed = ", ".join(labels[k] for k in order)
        return escaped(f"silos from the left: {listed or 'none'}")
    counted = ", ".join(f"{labels.count(label)} {label}" for label in sorted({*labels}))
    return escaped(f"{found.kind}s: {counted or 'none'}")


def photograph(pixels: NDArray[np.uint8], found: tuple[Any, ...]) -> bytes:
    """A picture, as wide as the screen's, with boxes and labels in it, as a JPEG file.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (h, w, 3)
        BGR.
    found : tuple of Detection2DArray

    Returns
    -------
    bytes

    Raises
    ------
    ValueError
        No picture.
    """
    import cv2

    if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype != np.uint8 or not pixels.size:
        raise ValueError(
            f"image_bgr: expected uint8 of shape (h, w, 3), got {pixels.dtype} of {pixels.shape}"
        )
    scale = WIDTH / pixels.shape[1]
    size = (WIDTH, max(1, round(pixels.shape[0] * scale)))
    picture = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA if scale < 1 else 1)
    for one in found:
        boxes = np.asarray(one.boxes, float).reshape(-1, 4) * scale
        for box, score, label in zip(boxes, one.scores, one.labels, strict=True):
            if np.isfinite(box).all():
                _frame(picture, box, str(label), float(score))
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()


def _frame(picture: NDArray[np.uint8], box: NDArray, label: str, score: float) -> None:
    """A box and its tag: above it, or within where there is no room."""
    import cv2

    height, width = picture.shape[:2]
    ends = np.clip(box, 0, [width - 1, height - 1] * 2).round().astype(int).tolist()
    left, top, right, bottom = ends
    colour = COLOURS.get(label, OTHER)
    cv2.rectangle(picture, (left, top), (right, bottom), colour, 1, cv2.LINE_AA)
    # cv2 draws ASCII alone.
    tag = f"{label} {number(score)}".encode("ascii", "replace").decode()
    style = (cv2.FONT_HERSHEY_SIMPLEX, 0.38)
    (wide, high), _ = cv2.getTextSize(tag, *style, 1)
    left = min(left, max(0, width - wide - 4))
    base = top if top > high + 4 else top + high + 4
    cv2.rectangle(picture, (left, base - high - 4), (left + wide + 4, base), colour, -1)
    cv2.putText(picture, tag, (left + 2, base - 3), *style, (0, 0, 0), 1, cv2.LINE_AA)

"""Polygons painted into a picture of pixels: for animations and live pictures, in milliseconds."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import ImageFont

from robocon_course._arrays import FloatArray
from robocon_course.view.body import Shape

Pixels = NDArray[np.uint8]
"""Shape (rows, columns, 3), RGB, row 0 at the top."""
FRACTION_BITS = 4


class Scale(NamedTuple):
    """Where the map lies in a picture.

    Attributes
    ----------
    per_metre : float  [pixel/m]
    left, bottom : float  [pixel]
        Column and row of the map's origin; rows count downwards.
    """

    per_metre: float
    left: float
    bottom: float

    def pixels(self, points: FloatArray) -> FloatArray:
        """Columns and rows of points [m, map], shape (n, 2); a pixel's middle lies at a half."""
        return np.array([self.left, self.bottom]) + points * [self.per_metre, -self.per_metre]

    def moved(self, columns: int, rows: int) -> Scale:
        """The scale of a piece that begins so many columns and rows further."""
        return self._replace(left=self.left - columns, bottom=self.bottom - rows)


def paint(picture: Pixels, shapes: Iterable[Shape], scale: Scale) -> None:
    """Paint polygons over a picture, with smooth edges."""
    import cv2

    for shape in shapes:
        fine = (scale.pixels(shape.corners) - 0.5) * (1 << FRACTION_BITS)
        corners = np.round(fine).astype(np.int32)[None]
        colour = rgb(shape.colour)
        style = {"lineType": cv2.LINE_AA, "shift": FRACTION_BITS}
        if shape.opacity == 1.0:
            cv2.fillPoly(picture, corners, colour, **style)
        else:
            over = picture.copy()
            cv2.fillPoly(over, corners, colour, **style)
            cv2.addWeighted(over, shape.opacity, picture, 1.0 - shape.opacity, 0.0, dst=picture)


def trace(picture: Pixels, points: FloatArray, scale: Scale, colour: str, width: int) -> None:
    """Paint a line through points [m, map], shape (n, 2), over a picture; width in pixels."""
    import cv2

    dots = np.round((scale.pixels(points) - 0.5) * (1 << FRACTION_BITS)).astype(np.int32)
    cv2.polylines(picture, [dots], False, rgb(colour), width, cv2.LINE_AA, FRACTION_BITS)


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue of a colour such as ``#0072B2``."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red, green, blue


@cache
def font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    """The plots' font, for words in a picture of pixels."""
    from matplotlib import font_manager

    name = font_manager.FontProperties(family="DejaVu Sans", weight="bold" if bold else "normal")
    return ImageFont.truetype(font_manager.findfont(name), size)

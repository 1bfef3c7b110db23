"""Polygons painted into a picture of pixels: for animations and live pictures, in milliseconds."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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


def paint(picture: Pixels, shapes: Iterable[Shape], scale: Scale) -> None:
    """Paint polygons over a picture, with smooth edges."""
    import cv2

    for shape in shapes:
        fine = (scale.pixels(shape.corners) - 0.5) * (1 << FRACTION_BITS)
        corners = np.round(fine).astype(np.int32)[None]
        colour = tuple(int(shape.colour[k : k + 2], 16) for k in (1, 3, 5))
        style = {"lineType": cv2.LINE_AA, "shift": FRACTION_BITS}
        if shape.opacity == 1.0:
            cv2.fillPoly(picture, corners, colour, **style)
        else:
            over = picture.copy()
            cv2.fillPoly(over, corners, colour, **style)
            cv2.addWeighted(over, shape.opacity, picture, 1.0 - shape.opacity, 0.0, dst=picture)

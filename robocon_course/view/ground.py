"""The field as a picture of pixels, for what is painted on it many times a second."""

from __future__ import annotations

from functools import cache

import numpy as np

from robocon_course import field
from robocon_course.view.field_picture import WHOLE_FIELD, field_edges
from robocon_course.view.raster import Pixels, Scale, paint


@cache
def painted_field(per_metre: int, pale: float) -> tuple[Pixels, Scale]:
    """The field with the largest y at the top, edges of steps and ramps marked, and its scale.

    Parameters
    ----------
    per_metre : int  [pixel/m]
        Has to make whole pixels of 12.1 m.
    pale : float, 0 to 1
        How far the floor is mixed with white.

    Returns
    -------
    ndarray of uint8, shape (n, n, 3)
        RGB, read-only.
    Scale
    """
    picture = field.picture(1.0 / per_metre)[::-1]
    floor = (picture * (1.0 - pale) + 255.0 * pale).astype(np.uint8)
    left, _, bottom, _ = WHOLE_FIELD
    scale = Scale(per_metre, -left * per_metre, len(floor) + bottom * per_metre)
    paint(floor, field_edges(), scale)
    floor.setflags(write=False)
    return floor, scale

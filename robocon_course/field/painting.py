"""The field from above in its true colours: what a camera sees of the floor, and plots draw on."""

from __future__ import annotations

from collections import Counter
from functools import cache

import numpy as np
from numpy.typing import NDArray

from robocon_course.field import layout, raster
from robocon_course.field.layout import Line, Rect

PixelArray = NDArray[np.uint8]


def picture(resolution: float = 0.01) -> PixelArray:
    """The field seen from above: floor, lines, zones, spots, frames and fences of both halves.

    Silos, balls and seedlings are not on it: they are things that stand on the floor.

    Parameters
    ----------
    resolution : float  [m per pixel]
        Has to divide 12.1 m into whole pixels.

    Returns
    -------
    ndarray of uint8, shape (n, n, 3)
        RGB; row 0 at the smallest y, as `height_map`. Read-only.

    Raises
    ------
    ValueError
        A resolution that does not divide 12.1 m.
    """
    return _picture(raster.cells_across(resolution))


@cache
def _picture(count: int) -> PixelArray:
    """`picture`, once per resolution."""
    pixels = np.empty((count, count, 3), dtype=np.uint8)
    flat = (layout.START_ZONE, layout.START_ZONE_R1, layout.RETRY_ZONE)
    raised = (layout.WATER_FRAME, layout.WATER, layout.WATER_BACK, layout.SEEDLING_RACK)
    strip = (layout.DIVIDER_1, layout.DIVIDER_2, layout.SILO_ZONE)
    _paint_all(pixels, (*layout.FLOOR, layout.RAMP_1, layout.RAMP_2, *flat))
    _paint_lines(pixels)
    _paint_all(pixels, (*raised, *strip, *layout.FENCES))
    _paint_spots(pixels)
    raster.mirror(pixels)
    other = pixels[:, (count + 1) // 2 :]
    other[(other == layout.RED).all(axis=-1)] = layout.BLUE
    pixels.setflags(write=False)
    return pixels


def _paint_all(pixels: PixelArray, rects: tuple[Rect, ...]) -> None:
    for rect in rects:
        raster.paint_rect(pixels, rect, rect.colour)


def _paint_lines(pixels: PixelArray) -> None:
    """White lines; where two end in one point they fill the corner."""
    lines = (*layout.GUIDE_LINES, *layout.FRAME_LINES, *layout.ROBOT_1_LINES)
    ends = Counter(end for x0, y0, x1, y1 in lines for end in ((x0, y0), (x1, y1)))
    half = layout.LINE_WIDTH / 2
    for line in lines:
        x0, y0, x1, y1 = _upwards(line)
        along_x = y0 == y1
        before = half * (ends[x0, y0] > 1)
        after = half * (ends[x1, y1] > 1)
        if along_x:
            edges = (x0 - before, y0 - half, x1 + after, y0 + half)
        else:
            edges = (x0 - half, y0 - before, x0 + half, y1 + after)
        pixels[raster.window(*edges, len(pixels))] = layout.WHITE


def _upwards(line: Line) -> Line:
    """The same line, from its smaller to its larger coordinates."""
    x0, y0, x1, y1 = line
    return Line(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))


def _paint_spots(pixels: PixelArray) -> None:
    """Holes of the rack, spots to plant and to harvest on, and the frame of the pile."""
    for hole in layout.SEEDLING_HOLES:
        raster.paint_disc(pixels, hole, layout.HOLE_DIAMETER, layout.WHITE)
    for spot in (*layout.PLANTING_SPOTS, *layout.HARVEST_SPOTS):
        raster.paint_disc(pixels, spot, layout.SPOT_DIAMETER, layout.WHITE)
    (x, y), half = layout.PILE, layout.PILE_HALF_DIAGONAL
    rows, cols = raster.window(x - half, y - half, x + half, y + half, len(pixels))
    across, up = raster.middles(len(pixels))
    # A square on its corner: |dx| + |dy| is the same all along its edge.
    far = np.abs(across[:, cols] - x) + np.abs(up[rows] - y)
    boards = (far <= half) & (far > half - layout.PILE_FRAME_WIDTH * 2.0**0.5)
    pixels[rows, cols][boards] = layout.GREY

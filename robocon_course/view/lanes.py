"""Boxes in rows and columns with arrows between them that cross no box."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path

WIDE, TALL = 1.66, 0.36
"""Of a box [inch]."""
STEP = (2.3, 1.0)
"""From one box to the next: in its row, in its column [inch]."""
ROUND = 0.09
"""Radius of a corner in an arrow [inch]."""
ASIDE = (0.0, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3)
"""Where the arrows of one lane, or at one side of a box, run beside each other [inch]."""
Point = tuple[float, float]
Place = tuple[int, int]


def middle(place: Place) -> Point:
    """Of the box at a place (column, row) [inch, y up]."""
    return STEP[0] * place[0], -STEP[1] * place[1]


def box_at(place: Place, **style: object) -> FancyBboxPatch:
    """A rounded box at a place (column, row)."""
    x, y = middle(place)
    shape = "round,pad=0.02,rounding_size=0.1"
    return FancyBboxPatch((x - WIDE / 2, y - TALL / 2), WIDE, TALL, boxstyle=shape, **style)


def arrows(ax: Axes, edges: Iterable[tuple[Place, Place]], widths: Sequence[float]) -> None:
    """Draw an arrow from box to box for each edge; its ends lie on the boxes' sides.

    Neighbours are joined straight. Other arrows leave their box towards the lane between two rows,
    and reach the next column or row in lanes alone.

    Parameters
    ----------
    ax : Axes
    edges : iterable of ((column, row), (column, row))
    widths : sequence of float, one for each edge  [points]
    """
    used: Counter = Counter()
    for (source, target), width in zip(edges, widths, strict=True):
        path = _rounded(_way(source, target, used))
        ax.add_patch(
            FancyArrowPatch(
                path=path, arrowstyle="-|>", mutation_scale=11, color="#555555", linewidth=width,
                joinstyle="round", zorder=2.5,
            )
        )  # fmt: skip


def _way(source: Place, target: Place, used: Counter) -> list[Point]:
    """Corners of an arrow's way from the side of one box to that of another."""

    def aside(*lane: object) -> float:
        """The next free place beside the arrows that run there already."""
        used[lane] += 1
        return ASIDE[(used[lane] - 1) % len(ASIDE)]

    (column, row), (to_column, to_row) = source, target
    (x, y), (to_x, to_y) = middle(source), middle(target)
    across, down = to_column - column, to_row - row
    if source == target:
        raise ValueError(f"edges: expected two boxes, got {source} twice")
    if down == 0 and abs(across) == 1:
        high = 0.07 * across  # there and back run beside each other
        return [(x + across * WIDE / 2, y + high), (to_x - across * WIDE / 2, to_y + high)]
    if across == 0 and abs(down) == 1:
        right = 0.12 * down
        return [(x + right, y - down * TALL / 2), (to_x + right, to_y + down * TALL / 2)]
    if across == 0:  # past the boxes between, outside their column
        side = -1 if column == 0 else 1
        lane = x + side * (WIDE / 2 + 0.3) + aside("column", column, side)
        ends = y + 0.5 * aside(source, side), to_y + 0.5 * aside(target, side)
        edge = x + side * WIDE / 2
        return [(edge, ends[0]), (lane, ends[0]), (lane, ends[1]), (edge, ends[1])]
    below = 1 if down > 0 else -1  # which lane: below the source, or above it
    start = x + 0.35 * (1 if across > 0 else -1) + 1.3 * aside(source, below)
    lane = y - below * STEP[1] / 2 + aside("row", row + min(0, below))
    if down in (0, below):  # into the target's top or bottom
        into = -below if down else below
        end = to_x - 0.35 * (1 if across > 0 else -1) + 1.3 * aside(target, into)
        return [
            (start, y - below * TALL / 2), (start, lane), (end, lane), (end, to_y - into * TALL / 2)
        ]  # fmt: skip
    side = -1 if across > 0 else 1  # into its side that faces the source
    up = to_x + side * (WIDE / 2 + 0.3) + aside("column", to_column, side)
    end = to_y + 0.5 * aside(target, side)
    return [
        (start, y - below * TALL / 2), (start, lane), (up, lane), (up, end),
        (to_x + side * WIDE / 2, end),
    ]  # fmt: skip


def _rounded(points: list[Point]) -> Path:
    """A way with round corners."""
    vertices, codes = [points[0]], [Path.MOVETO]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        vertices += [_towards(corner, before), corner, _towards(corner, after)]
        codes += [Path.LINETO, Path.CURVE3, Path.CURVE3]
    return Path([*vertices, points[-1]], [*codes, Path.LINETO])


def _towards(corner: Point, other: Point) -> Point:
    """A little way from a corner to another one."""
    far = max(abs(other[0] - corner[0]), abs(other[1] - corner[1]), 1e-9)
    share = min(ROUND, far / 2) / far
    return (
        corner[0] + share * (other[0] - corner[0]),
        corner[1] + share * (other[1] - corner[1]),
    )

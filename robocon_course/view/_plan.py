"""The game field from above, with everything named: chapter 00's first picture."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.robot import SIDE
from robocon_course.view.canvas import MINE, TRUTH, figure, styled
from robocon_course.view.field_picture import WHOLE_FIELD, draw_ground

PALE = 0.55
"""How far the opponent's half is mixed with white."""


@styled()
def draw_plan(way: ArrayLike | None = field.WAY_TO_AREA_3) -> Figure:
    """Plan of the game field with Robot 2 at its start, y to the north.

    Parameters
    ----------
    way : array_like, shape (n, 2), optional  [m, map]
        The robot's way, drawn as dots; None draws none.

    Returns
    -------
    Figure
    """
    fig, ax = figure(8.2, 7.9)
    draw_ground(ax, WHOLE_FIELD, pale=0.0)
    ax.grid(visible=False)
    right, top = field.SILO_ZONE.x1, WHOLE_FIELD[3]
    veil = {"color": "white", "alpha": PALE, "linewidth": 0.0, "zorder": 3}
    low = WHOLE_FIELD[0]
    ax.add_patch(Rectangle((right, low), WHOLE_FIELD[1] - right, top - low, **veil))
    _draw_balls(ax)
    _draw_arrows(ax)
    for number, silo in enumerate(field.SILOS, start=1):
        style = {"facecolor": "white", "edgecolor": TRUTH, "linewidth": 1.4, "zorder": 4}
        ax.add_patch(Circle(silo, field.SILO_DIAMETER / 2, **style))
        ax.text(*silo, str(number), ha="center", va="center_baseline", fontsize=8, zorder=5)
    for x, y, words, style in PLAN_WORDS:
        style = {"ha": "center", "va": "center", "color": TRUTH, "zorder": 5} | style
        ax.text(x, y, words, **style)
    if way is not None:
        _draw_way(ax, as_floats(way, "way", None, 2))
    return fig


BIG, SMALL, LEFT = {"fontsize": 10.5}, {"fontsize": 9}, {"fontsize": 9, "ha": "left"}
PLAN_WORDS = (
    (3.85, 0.8, "AREA 1, floor 0.05 m", BIG),
    (3.85, 4.5, "AREA 2, floor 0.15 m", BIG),
    (3.77, 11.35, "AREA 3,\nfloor\n0.25 m", BIG),
    (1.125, 11.45, "STORAGE ZONE,\nfloor 0.15 m", BIG),
    (1.9, 7.5, "WATER ZONE", BIG),
    (2.75, 8.5, "slope,\n← down", SMALL),
    (3.63, 2.49, "12 planting spots", SMALL),
    (3.63, 5.5, "harvest: 6 red, 6 empty", SMALL),
    (1.125, 9.1, "pile of 16 balls", SMALL),
    (4.6, 3.8, "step 0.10 m", SMALL),
    (5.36, 7.75, "step", SMALL),
    (1.12, 3.8, "ramp", LEFT),
    (4.93, 7.2, "ramp", LEFT),
    (0.77, 5.5, "retry", LEFT),
    (0.65, 1.0, "start (0.55, 0.35)", LEFT),
    (4.4, 10.36, "goal\n(4.30, 10.00)", LEFT),
    (0.65, 6.65, "Robot 2's way to Area 3", LEFT),
    (1.25, 0.35, "R1", SMALL | {"color": "white", "fontweight": "bold"}),
    (6.25, 10.375, "silos 1 to 5,\nshared", BIG | {"ha": "left"}),
    (9.1, 4.45, "opponent's half:\nthe mirror image, x → 12 − x", BIG | {"style": "italic"}),
)


def _draw_balls(ax: Axes) -> None:
    """The balls where the rulebook's picture has them, on both sides."""
    balls = zip(
        field.PILE_BALLS + field.HARVEST_SPOTS,
        field.PILE_EXAMPLE + field.HARVEST_EXAMPLE,
        strict=True,
    )
    for (x, y), colour in balls:
        other = field.BLUE if colour == field.RED else colour
        for place, paint in (((x, y), colour), ((field.SIZE - x, y), other)):
            style = {"facecolor": [part / 255 for part in paint], "edgecolor": "white"}
            zorder = 4 if paint is colour and place[0] == x else 2
            size = field.BALL_DIAMETER / 2
            ax.add_patch(Circle(place, size, linewidth=0.6, zorder=zorder, **style))


def _draw_arrows(ax: Axes) -> None:
    """Arrow heads up the ramps."""
    for ramp in (field.RAMP_1, field.RAMP_2):
        x, _ = ramp.centre
        for y in (ramp.y0 + 0.35, ramp.y0 + 0.6, ramp.y0 + 0.85):
            style = {"color": TRUTH, "alpha": 0.55, "linewidth": 1.4, "zorder": 4}
            ax.plot((x - 0.28, x, x + 0.28), (y - 0.16, y, y - 0.16), **style)


def _draw_way(ax: Axes, way: FloatArray) -> None:
    ax.plot(way[:, 0], way[:, 1], ":", color=MINE, linewidth=2.6, zorder=6)
    x, y = way[0]
    half = SIDE / 2
    body = {"facecolor": "#FFFFFFE0", "edgecolor": MINE, "linewidth": 2.0, "zorder": 7}
    ax.add_patch(Rectangle((x - half, y - half), SIDE, SIDE, **body))
    words = {"ha": "center", "va": "center", "fontweight": "bold", "color": MINE, "zorder": 8}
    ax.text(x, y, "R2", **words)
    ring = {"markersize": 11, "markerfacecolor": "white", "markeredgewidth": 2.4}
    ax.plot(*way[-1], "o", markeredgecolor=MINE, zorder=7, **ring)

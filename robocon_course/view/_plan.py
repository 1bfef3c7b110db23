"""The game field from above."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle
from matplotlib.transforms import Affine2D, Transform
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.view.canvas import MINE, TRUTH, figure, styled

ROBOT_SIZE = 0.65
PALE = 0.62
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
    ax.set(xlim=(-0.12, 12.12), ylim=(-0.12, 12.12), aspect="equal")
    ax.set(xticks=range(0, 13), yticks=range(0, 13), xlabel="x [m]", ylabel="y [m]")
    ax.grid(visible=False)
    ax.spines[["left", "bottom"]].set_visible(False)
    rim, size = field.FENCE_THICKNESS, field.SIZE + 2 * field.FENCE_THICKNESS
    ax.add_patch(Rectangle((-rim, -rim), size, size, color=_paint(field.GREY)))
    mirrored = Affine2D().scale(-1.0, 1.0).translate(field.SIZE, 0.0) + ax.transData
    _draw_half(ax, mirrored, PALE)
    _draw_half(ax, ax.transData, 0.0)
    for number, silo in enumerate(field.SILOS, start=1):
        style = {"facecolor": "white", "edgecolor": TRUTH, "linewidth": 1.4, "zorder": 4}
        ax.add_patch(Circle(silo, field.SILO_DIAMETER / 2, **style))
        ax.text(*silo, str(number), ha="center", va="center_baseline", fontsize=8, zorder=5)
    for x, y, words, style in PLAN_WORDS:
        ax.text(x, y, words, **{"ha": "center", "va": "center", "color": TRUTH} | style)
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
    (1.06, 3.8, "ramp", LEFT),
    (4.86, 7.2, "ramp", LEFT),
    (0.77, 5.5, "retry", LEFT),
    (0.65, 1.0, "start (0.55, 0.35)", LEFT),
    (4.4, 10.36, "goal\n(4.30, 10.00)", LEFT),
    (0.65, 6.65, "Robot 2's way to Area 3", LEFT),
    (1.25, 0.35, "R1", SMALL | {"color": "white", "fontweight": "bold"}),
    (6.25, 10.375, "silos 1 to 5,\nshared", BIG | {"ha": "left"}),
    (9.1, 4.45, "opponent's half:\nthe mirror image, x → 12 − x", BIG | {"style": "italic"}),
)


def _paint(colour: field.Colour, pale: float = 0.0) -> tuple[float, ...]:
    """A colour mixed with white; the pale half is the blue team's."""
    colour = field.BLUE if pale and colour == field.RED else colour
    return tuple((c + (255 - c) * pale) / 255 for c in colour)


def _draw_half(ax: Axes, transform: Transform, pale: float) -> None:
    """One team's half: ours in its true colours, or the opponent's mirrored and pale."""
    for rect in (*field.FLOOR, field.WATER_FRAME, field.WATER, *field.ZONES):
        outlined = rect in field.ZONES or any(rect.slope)
        edge = {"edgecolor": "#00000040", "linewidth": 0.8 if outlined else 0.0}
        size = rect.x1 - rect.x0, rect.y1 - rect.y0
        style = edge | {"facecolor": _paint(rect.colour, pale), "transform": transform}
        ax.add_patch(Rectangle((rect.x0, rect.y0), *size, **style))
    _draw_strokes(ax, transform, pale)
    for holes, diameter in (
        (field.SEEDLING_HOLES, field.HOLE_DIAMETER),
        (field.PLANTING_SPOTS, field.SPOT_DIAMETER),
    ):
        for hole in holes:
            ax.add_patch(Circle(hole, diameter / 2, color="white", transform=transform))
    half, (x, y) = field.PILE_HALF_DIAGONAL, field.PILE
    corners = [(x - half, y), (x, y - half), (x + half, y), (x, y + half)]
    frame = {"facecolor": "none", "edgecolor": _paint(field.GREY, pale), "linewidth": 3.0}
    ax.add_patch(Polygon(corners, transform=transform, **frame))
    balls = field.PILE_BALLS + field.HARVEST_SPOTS
    for ball, colour in zip(balls, field.PILE_EXAMPLE + field.HARVEST_EXAMPLE, strict=True):
        style = {"facecolor": _paint(colour, pale), "edgecolor": "white", "linewidth": 0.6}
        ax.add_patch(Circle(ball, field.BALL_DIAMETER / 2, transform=transform, **style))


def _draw_strokes(ax: Axes, transform: Transform, pale: float) -> None:
    """Arrow heads up the ramps, edges of the steps, and the white lines."""
    dark = {"color": TRUTH, "alpha": 0.55 * (1.0 - pale), "transform": transform}
    for ramp in (field.RAMP_1, field.RAMP_2):
        x, _ = ramp.centre
        for y in (ramp.y0 + 0.35, ramp.y0 + 0.6, ramp.y0 + 0.85):
            ax.plot((x - 0.28, x, x + 0.28), (y - 0.16, y, y - 0.16), linewidth=1.4, **dark)
    white = {"color": "white", "solid_capstyle": "butt", "transform": transform}
    for lines, style in (
        (field.STEPS, dark | {"linewidth": 2.2}),
        (field.GUIDE_LINES + field.FRAME_LINES, white | {"linewidth": 1.6}),
        (field.ROBOT_1_LINES, white | {"linewidth": 0.8, "alpha": 0.7}),
    ):
        for line in lines:
            ax.plot((line.x0, line.x1), (line.y0, line.y1), **style)


def _draw_way(ax: Axes, way: FloatArray) -> None:
    ax.plot(way[:, 0], way[:, 1], ":", color=MINE, linewidth=2.6, zorder=6)
    x, y = way[0]
    half = ROBOT_SIZE / 2
    body = {"facecolor": "#FFFFFFE0", "edgecolor": MINE, "linewidth": 2.0, "zorder": 7}
    ax.add_patch(Rectangle((x - half, y - half), ROBOT_SIZE, ROBOT_SIZE, **body))
    words = {"ha": "center", "va": "center", "fontweight": "bold", "color": MINE, "zorder": 8}
    ax.text(x, y, "R2", **words)
    ring = {"markersize": 11, "markerfacecolor": "white", "markeredgewidth": 2.4}
    ax.plot(*way[-1], "o", markeredgecolor=MINE, zorder=7, **ring)

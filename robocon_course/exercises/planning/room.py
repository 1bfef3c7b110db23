"""Room for a square body, and how people get it wrong."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from robocon_course import worlds
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.planning.maps import drawn_grid, some_grid
from robocon_course.gridmap import GridMap, inflate, inflate_square
from robocon_course.worlds import Student

LONE = "......... ......... ......... ...#..... ......... ......... ......... ........."
NEAR_EDGE = "............ ............ ............ ............ .#.......... ............"
WALL = "............ ............ ............ ............ #####....... ............ ............"


def _cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases = [
        ("one obstacle alone", drawn_grid(LONE, 0.1, (1.0, -2.0)), 0.2),
        ("a wall, and a half of two cells and a bit", drawn_grid(WALL, 0.05), 0.12),
        ("no obstacle: only the edge of the map", GridMap(np.ones((9, 12), bool), 0.5), 1.3),
        ("a half of exactly three cells", GridMap(np.ones((9, 12), bool), 0.1), 3 * 0.1),
        ("an obstacle beside the map's corner", drawn_grid(NEAR_EDGE, 0.1), 0.2),
        ("a body without size", drawn_grid(LONE, 0.1), 0.0),
    ]
    for _ in range(4):
        grid = some_grid(rng, 19, 23, 0.01)
        cases.append(("a map of your own", grid, round(rng.uniform(1.1, 3.9) * grid.resolution, 3)))
    whole = some_grid(rng, 17, 20, 0.015)
    cases.append(("a half of exactly two cells", whole, 2 * whole.resolution))
    cases.append(("the game field with boxes", worlds.passable_field(rng), 0.325))
    atol = {"free": 0.0, "resolution": 1e-12, "origin": 1e-12}
    return [Case(what, args, "", atol) for what, *args in ((w, g, h) for w, g, h in cases)]


def _grown(
    *,
    reach: Callable[[float], int] = lambda cells: math.ceil(cells - 1e-9),
    rows: bool = True,
    cols: bool = True,
    edge: str = "blocked",
    free: bool = False,
    diamond: bool = False,
    origin: bool = True,
) -> Callable[[GridMap, float], GridMap]:
    """Blocked cells grown by shifted copies, with one step done wrongly."""

    def function(grid: GridMap, half: float) -> GridMap:
        n = reach(half / grid.resolution)
        blocked = grid.free if free else ~grid.free
        mode = {"mode": "wrap"} if edge == "wrap" else {"constant_values": edge == "blocked"}
        padded = np.pad(blocked, n, **mode)
        grown = np.zeros_like(blocked)
        for row in range(-n if rows else 0, n + 1 if rows else 1):
            for col in range(-n if cols else 0, n + 1 if cols else 1):
                if diamond and abs(row) + abs(col) > n:
                    continue
                down, right = row + n, col + n
                grown |= padded[down : down + grown.shape[0], right : right + grown.shape[1]]
        return GridMap(
            grown if free else ~grown, grid.resolution, grid.origin if origin else (0.0, 0.0)
        )

    return function


def _by_slices(grid: GridMap, half: float) -> GridMap:
    """A slice around each obstacle, which beside the edge begins below 0."""
    n = math.ceil(half / grid.resolution - 1e-9)
    free = np.zeros_like(grid.free)
    rows, cols = grid.shape
    free[n : rows - n, n : cols - n] = True
    for row, col in np.argwhere(~grid.free):
        free[row - n : row + n + 1, col - n : col + n + 1] = False
    return GridMap(free, grid.resolution, grid.origin)


def _rim_cut_off(grid: GridMap, half: float) -> GridMap:
    """A rim of no cells cut off by -0, which leaves nothing."""
    n = math.ceil(half / grid.resolution - 1e-9)
    free = inflate_square(grid, half).free
    return GridMap(np.pad(free, n)[n:-n, n:-n], grid.resolution, grid.origin)


INFLATE_SQUARE = Exercise(
    id="planning.inflate_square",
    title="Room for a square body",
    points=3,
    reference=inflate_square,
    cases=_cases,
    time_limit=10.0,
    hints=(
        "A cell is blocked if any cell up to n rows and n columns away is blocked. The edge counts "
        "like blocked cells: np.pad(~grid.free, n, constant_values=True) puts them around.",
        "For each shift of 0 to 2n rows and 0 to 2n columns take the piece of the padded array "
        "that is as large as the map, and collect them with |=.",
        "grown |= padded[r : r + rows, c : c + cols] for r and c in range(2 * n + 1); the result "
        "is GridMap(~grown, grid.resolution, grid.origin).",
    ),
    mistakes=(
        Mistake(
            "a disc",
            "The corners are round: this is room for a disc. A square whose middle passes an "
            "obstacle's corner at that distance hits it with its own corner. Rows and columns "
            "count each for itself.",
            inflate,
        ),
        Mistake(
            "rounded down",
            "A part of a cell is forgotten: 6.5 cells take 7. Round up with math.ceil.",
            _grown(reach=lambda cells: int(cells + 1e-9)),
        ),
        Mistake(
            "rounded to the nearest",
            "The number of cells is rounded to the nearest. The robot is not smaller because the "
            "cells are coarse: round up.",
            _grown(reach=round),
        ),
        Mistake(
            "a cell lost to rounding",
            "3 · 0.1 is 0.30000000000000004, and that over 0.1 is more than 3: rounded up it costs "
            "a cell. Subtract 1e-9 before you round up.",
            _grown(reach=math.ceil),
        ),
        Mistake(
            "one cell too many",
            "One cell too many is blocked. Between two cells that are n apart lie n − 1: that gap "
            "has to be at least half, so n = ceil(half / resolution) rows are blocked.",
            _grown(reach=lambda cells: math.ceil(cells - 1e-9) + (cells > 0)),
        ),
        Mistake(
            "one cell too few",
            "One cell too few is blocked. Every point of a free cell must have room, that on its "
            "near side too: n = ceil(half / resolution).",
            _grown(reach=lambda cells: max(math.ceil(cells - 1e-9) - 1, 0)),
        ),
        Mistake(
            "edge of the map forgotten",
            "Beside the edge of the map there is no room for the robot: what lies outside is not "
            "known to be free. Pad the map with blocked cells.",
            _grown(edge="free"),
        ),
        Mistake(
            "around the edge",
            "Obstacles grow out of the map and come in on the other side, as np.roll does it. Pad "
            "the map first.",
            _grown(edge="wrap"),
        ),
        Mistake(
            "slice below 0",
            "A slice from r - n to r + n + 1 is empty where r - n is below 0: a negative index "
            "begins at the other end. Use max(r - n, 0), and the same for the columns.",
            _by_slices,
        ),
        Mistake(
            "rim of no cells cut off",
            "With n = 0 the slice [n:-n] is [0:0], which is empty. Write [n : n + rows, "
            "n : n + cols].",
            _rim_cut_off,
        ),
        Mistake(
            "only rows",
            "Obstacles grow in y only. They have to grow along the columns, too.",
            _grown(cols=False),
        ),
        Mistake(
            "only columns",
            "Obstacles grow in x only. They have to grow along the rows, too.",
            _grown(rows=False),
        ),
        Mistake(
            "a diamond",
            "Rows and columns are added: this is a square on its tip. The body's corner reaches n "
            "rows and n columns far at once.",
            _grown(diamond=True),
        ),
        Mistake(
            "free cells grown",
            "The free cells have grown, and the obstacles have shrunk. Grow the blocked ones: "
            "~grid.free.",
            _grown(free=True),
        ),
        Mistake(
            "half of half",
            "Obstacles grow by a quarter of the side only: half is half the side already.",
            _grown(reach=lambda cells: math.ceil(cells / 2 - 1e-9)),
        ),
        Mistake(
            "the whole side",
            "Obstacles grow by the whole side. The middle of the robot needs half of it.",
            _grown(reach=lambda cells: math.ceil(2 * cells - 1e-9)),
        ),
        Mistake(
            "origin lost",
            "The cells are right, and the map has moved: hand grid.origin on to GridMap.",
            _grown(origin=False),
        ),
        Mistake(
            "unchanged",
            "This returns the map as it came. There the robot is a point.",
            lambda grid, half: grid,
        ),
    ),
)

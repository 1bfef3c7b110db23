"""A*, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import field, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.planning.maps import (
    drawn_grid,
    point_in,
    some_ends,
    some_grid,
    way_of,
)
from robocon_course.exercises.planning.plain import (
    as_it_is,
    from_start,
    manhattan,
    plain_astar,
    upside_down,
    without_origin,
)
from robocon_course.exercises.planning.same_way import looked_at, way_case
from robocon_course.gridmap import GridMap, inflate_square
from robocon_course.planning import Plan, astar
from robocon_course.planning.steps import DIRECTIONS
from robocon_course.worlds import Student

WRONG = {
    "manhattan": plain_astar(h=manhattan),
    "diagonal": plain_astar(diagonal=1.0),
    "seen": plain_astar(seen=True),
    "greedy": plain_astar(greedy=True),
    "f": plain_astar(adding="f"),
}
"""Whether these find a longer way depends on the map."""
SMALL = "....... ..###.. ..#.#.. ..###.. ......."


def trap(rng: np.random.Generator, wrong: Callable[..., Plan | None]) -> tuple:
    """A map of one's own where a wrong search, and no other, finds a way too long by so much."""
    others = [other for other in WRONG.values() if other is not wrong]
    while True:
        grid = some_grid(rng, 16, 20, 0.3)
        ends = some_ends(rng, grid)
        best = way_of(grid, *ends)
        if best is None:
            continue
        length, close = wrong(grid, *ends).length, 0.1 * grid.resolution
        if length > best.length + close and all(
            abs(other(grid, *ends).length - length) > close for other in others
        ):
            return grid, *ends


def _cases(student: Student, rng: np.random.Generator) -> list[Case]:
    walled = drawn_grid(SMALL, 0.5, (-1.0, 2.0))
    empty = GridMap(np.ones((41, 45), dtype=bool), 0.1, (-0.5, 0.3))
    middle, aside = (20, 22), (int(rng.integers(28, 36)), int(rng.integers(36, 44)))
    ends = [point_in(rng, empty, cell) for cell in (middle, aside)]
    here, there, inside, solid = (
        point_in(rng, walled, c) for c in ((0, 1), (4, 5), (2, 3), (1, 3))
    )
    cases = [
        way_case("around a walled cell", walled, here, there),
        way_case("the goal is walled in", walled, here, inside),
        way_case("the start lies in an obstacle", walled, solid, here),
        way_case("start and goal in one cell", walled, there, there + 0.01),
        way_case(
            "an empty room", empty, *ends, most=10 + 2 * looked_at(empty.shape, middle, aside)
        ),
    ]
    cases += [way_case("a map of your own", *trap(rng, wrong)) for wrong in WRONG.values()]
    room = inflate_square(worlds.passable_field(rng), worlds.HALF)
    ends = (np.array(field.START), np.array(field.AREA_3_GOAL))
    whole = "the game field with boxes"
    return [*cases, way_case(whole, room, *ends, timed="The way over the field")]


ASTAR = Exercise(
    id="planning.astar",
    title="A*: the shortest way",
    points=5,
    reference=astar,
    shortcuts=(
        "robocon_course.planning.shortest.anytime_astar",
        "robocon_course.planning.search.search",
        "robocon_course.planning.replanning.Replanner.plan",
        "robocon_course.planning.replanning.repair",
    ),
    cases=_cases,
    time_limit=15.0,
    hints=(
        "Keep three things: cost[cell] so far, came_from[cell], and a heap of (cost + h, cell). "
        "Take the smallest, and look at its neighbours.",
        "A neighbour is worth an entry if it was never reached or is reached more cheaply now: "
        "new = cost[cell] + step; if new < cost.get(to, math.inf). Take notice of cells taken out "
        "before, and leave them out.",
        "Stop when the goal is taken from the heap, not when it is seen. Then go back along "
        "came_from until you stand at the start, and turn the list round.",
        "If the heap is empty first, raise planning.NoPathError('no way', 'enclosed'). A start "
        "that is not free has no way either: grid.is_free(start).",
    ),
    mistakes=(
        Mistake(
            "Manhattan",
            "h is the Manhattan distance. With diagonal steps it is more than what is left, so a "
            "better way may never be looked at. Use octile_distance.",
            WRONG["manhattan"],
        ),
        Mistake(
            "corners cut",
            "Diagonal steps pass obstacles' corners. Both cells beside such a step have to be "
            "free: use your neighbours.",
            plain_astar(corners=True),
        ),
        Mistake(
            "four neighbours",
            "The way has no diagonal steps. Every cell has eight neighbours.",
            plain_astar(directions=DIRECTIONS[::2], h=manhattan),
        ),
        Mistake(
            "diagonal for one",
            "A diagonal step counts like a straight one here: zigzags cost nothing. It costs √2.",
            WRONG["diagonal"],
        ),
        Mistake(
            "closed when seen",
            "A cell that was seen once never becomes cheaper here. Compare costs: new < cost[to] "
            "is worth a second entry.",
            WRONG["seen"],
        ),
        Mistake(
            "only h",
            "The heap is sorted by h alone. That runs straight at the goal and forgets how far it "
            "has come: sort by cost + h.",
            WRONG["greedy"],
        ),
        Mistake(
            "step added to f",
            "The step is added to what the heap is sorted by, so h is counted again with every "
            "step. Only the cost so far grows: new = cost[cell] + step.",
            WRONG["f"],
        ),
        Mistake(
            "h does not look to the goal",
            "The search spreads to all sides. h is left out, or it is the distance from the start, "
            "as two theses print it. It has to be the distance from the cell to the goal.",
            plain_astar(h=from_start),
        ),
        Mistake(
            "from goal to start",
            "The way runs from goal to start. Going back along came_from gives it the wrong way "
            "round: reverse it.",
            plain_astar(order=slice(None, None, -1)),
        ),
        Mistake(
            "start left out",
            "The first cell of the way is missing. Start and goal belong to it.",
            plain_astar(order=slice(1, None)),
        ),
        Mistake(
            "goal left out",
            "The last cell of the way is missing. Start and goal belong to it.",
            plain_astar(order=slice(None, -1)),
        ),
        Mistake(
            "row and column swapped",
            "x and y were taken for row and column. grid.cells(point) gives (row, col): y first.",
            plain_astar(cell_of=lambda grid, point: as_it_is(grid, point)[::-1]),
        ),
        Mistake(
            "y down",
            "Rows are counted from above, as in a picture. Row 0 lies at the smallest y.",
            plain_astar(cell_of=upside_down),
        ),
        Mistake(
            "origin forgotten",
            "The map's origin was forgotten: cell (0, 0) does not begin at (0, 0) m. Use "
            "grid.cells(point).",
            plain_astar(cell_of=without_origin),
        ),
        Mistake(
            "None for no way",
            "Where there is no way this returns None, and whoever drives it finds out later. "
            "Raise planning.NoPathError with the reason.",
            plain_astar(none=True),
        ),
        Mistake(
            "start not asked",
            "A start in an obstacle is not noticed. Ask grid.is_free(start), and raise "
            "planning.NoPathError.",
            plain_astar(ask=False),
        ),
    ),
)

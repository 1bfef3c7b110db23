"""Which steps are open from a cell, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from robocon_course.answers.process import Reply
from robocon_course.answers.wire import Foreign
from robocon_course.exercises.compare import NOTHING
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.planning.maps import Cell, drawn_grid, some_grid
from robocon_course.gridmap import GridMap
from robocon_course.planning import neighbours
from robocon_course.planning.steps import DIRECTIONS, ROOT_2
from robocon_course.worlds import Student

CLOSE = 1e-9
OPEN = "....... ....... ....... ....... ......."
CORNER = "...... .#.... ...... ....#. ......"
BETWEEN = "..... ..#.. .#... ..... ....."


def steps_case(what: str, grid: GridMap, cell: Cell) -> Case:
    """A case whose answer is right if it holds the reference's steps, in any order."""

    def judge(reply: Reply) -> str | None:
        if reply.error:
            return f"{reply.error}: {reply.message}"
        try:
            came = steps_of(reply.value)
        except (TypeError, ValueError, IndexError, AttributeError):
            if reply.value is None:
                return NOTHING
            came = f", got a {reply.value.type_name}" if isinstance(reply.value, Foreign) else ""
            return f"expected a list of pairs ((row, col), cost), each cell once{came}"
        wanted = steps_of(neighbours(grid, cell))
        for to in sorted(wanted.keys() - came.keys()):
            return f"from {cell} the step to {to} is missing"
        for to in sorted(came.keys() - wanted.keys()):
            return f"from {cell} no step leads to {to}"
        for to, cost in wanted.items():
            if abs(came[to] - cost) > CLOSE:
                return f"the step from {cell} to {to} costs {cost:.4g} cells, got {came[to]:.4g}"
        return None

    return Case(what, (grid, cell), judge=judge, traits=steps_of)


def steps_of(value: Any) -> dict[Cell, float]:
    """Steps by the cell they lead to; refuses what has not the form of steps."""
    if not isinstance(value, list | tuple):
        raise TypeError("not a list")
    steps: dict[Cell, float] = {}
    for (row, col), cost in value:
        to = (int(row), int(col))
        if to != (row, col) or to in steps:
            raise ValueError("no cell, or twice the same")
        steps[to] = float(cost)
    return steps


def _neighbours_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases = [
        steps_case("all around is free", drawn_grid(OPEN, 0.05), (2, 3)),
        steps_case("an obstacle beside the way", drawn_grid(CORNER, 0.05), (3, 2)),
        steps_case("between two obstacles", drawn_grid(BETWEEN, 0.05), (2, 2)),
        steps_case("an obstacle ahead on the diagonal", drawn_grid(CORNER, 0.05), (2, 2)),
        steps_case("the lower left corner of the map", drawn_grid(OPEN, 0.05), (0, 0)),
        steps_case("the upper right corner of the map", drawn_grid(OPEN, 0.05), (4, 6)),
    ]
    for _ in range(8):
        grid = some_grid(rng, 6, 9, 0.25)
        cell = tuple(rng.choice(np.argwhere(grid.free)).tolist())
        cases.append(steps_case("a cell of your own", grid, cell))
    return cases


def _steps(
    *,
    directions: tuple[Cell, ...] = DIRECTIONS,
    corners: str = "both",
    edge: str = "asked",
    diagonal: float = ROOT_2,
    wanted: bool = True,
    order: slice = slice(None),
    scaled: bool = False,
) -> Callable[[GridMap, Cell], list]:
    """Steps to neighbours, with one rule wrong."""

    def function(grid: GridMap, cell: Cell) -> list:
        (rows, cols), free, found = grid.shape, grid.free, []
        row, col = cell
        low, high = (1, 1) if edge == "left out" else (0, 0)
        for d_row, d_col in directions:
            to = row + d_row, col + d_col
            inside = low <= to[0] < rows - high and low <= to[1] < cols - high
            if (edge != "not asked" and not inside) or free[to] != wanted:
                continue
            if d_row and d_col:
                beside = [free[row + d_row, col], free[row, col + d_col]]
                if not {"both": all, "one": any, "cut": lambda two: True}[corners](beside):
                    continue
            cost = (diagonal if d_row and d_col else 1.0) * (grid.resolution if scaled else 1.0)
            found.append((to[order], cost))
        return found

    return function


NEIGHBOURS = Exercise(
    id="planning.neighbours",
    title="Which steps are open",
    points=3,
    reference=neighbours,
    shortcuts=(
        "robocon_course.planning.moves.may_step",
        "robocon_course.planning.shortest.astar",
        "robocon_course.planning.shortest.anytime_astar",
        "robocon_course.planning.replanning.Replanner.plan",
    ),
    cases=_neighbours_cases,
    hints=(
        "Two loops over −1, 0, 1 give nine cells. Leave out the cell itself, what lies outside the "
        "map, and what is not free.",
        "A diagonal step passes grid.free[row + dr, col] and grid.free[row, col + dc]; both have "
        "to be free.",
        "For each that is left append ((row + dr, col + dc), math.sqrt(2) if dr and dc else 1.0). "
        "Ask 0 <= row + dr < rows before you look into grid.free.",
    ),
    mistakes=(
        Mistake(
            "four neighbours",
            "Diagonal steps are missing: the robot can drive in eight directions.",
            _steps(directions=DIRECTIONS[::2]),
        ),
        Mistake(
            "corners cut",
            "A diagonal step passes between two cells. An obstacle in one of them would be hit: "
            "both have to be free.",
            _steps(corners="cut"),
        ),
        Mistake(
            "one free cell beside is enough",
            "A diagonal step is allowed with one free cell beside it. Both have to be free: use "
            "and, not or.",
            _steps(corners="one"),
        ),
        Mistake(
            "edge of the map not asked",
            "grid.free[-1] is the last row: below the map begins its upper end, and above it "
            "Python raises an IndexError. Ask first whether the neighbour lies in the map.",
            _steps(edge="not asked"),
        ),
        Mistake(
            "outer cells left out",
            "Cells at the edge of the map count as not free. They are cells like all others: "
            "0 <= row < rows.",
            _steps(edge="left out"),
        ),
        Mistake(
            "the cell itself",
            "The cell is its own neighbour here. Leave out the step (0, 0).",
            lambda grid, cell: [(cell, 0.0), *neighbours(grid, cell)],
        ),
        Mistake(
            "diagonal for one",
            "A diagonal step costs 1 here. It is √2 long.",
            _steps(diagonal=1.0),
        ),
        Mistake(
            "14 for 10 times the root",
            "A diagonal step costs 1.4 here, as if it were 14 where a straight one is 10. √2 is a "
            "little more, and then h is not admissible.",
            _steps(diagonal=1.4),
        ),
        Mistake(
            "a diagonal step for two",
            "A diagonal step costs 2 here, like two straight ones. It is √2 long.",
            _steps(diagonal=2.0),
        ),
        Mistake(
            "in metres",
            "Costs are in metres here. The question asks for cells: 1 and √2.",
            _steps(scaled=True),
        ),
        Mistake(
            "row and column swapped",
            "Cells come out as (col, row). Everywhere in the course it is (row, col).",
            _steps(order=slice(None, None, -1)),
        ),
        Mistake(
            "obstacles for free cells",
            "These are the neighbours that are not free. grid.free is True where the robot may be.",
            _steps(wanted=False),
        ),
        Mistake(
            "cells without costs",
            "Only the cells come out. Each needs its cost beside it: ((row, col), cost).",
            lambda grid, cell: [to for to, _ in neighbours(grid, cell)],
        ),
    ),
)

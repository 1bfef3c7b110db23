"""How fast is A* beside its peers?

    python benchmarks/planning.py

One process; contenders take turns; the median of the repeats counts, in CPU time. Where the rule
(may corners be cut?) and the cost model are the same, equal costs are asserted before any time is
taken. pyastar2d counts moves, not lengths: its ways are longer, and only its time is compared.
skimage, networkx and pathfinding get their own maps ready made, ours a `GridMap`.
"""

from __future__ import annotations

import tracemalloc
from math import hypot, sqrt

import networkx
import numpy as np
import pyastar2d
from pathfinding.core.diagonal_movement import DiagonalMovement
from pathfinding.core.grid import Grid
from pathfinding.finder.a_star import AStarFinder
from skimage.graph import MCP_Geometric
from turns import medians

from robocon_course import field
from robocon_course.gridmap import GridMap, inflate
from robocon_course.planning import Replanner, anytime_astar, astar

REPEATS = 7
START, GOAL, RADIUS = (0.55, 0.35), (4.30, 10.00), 0.325  # m
Cell = tuple[int, int]


def random_map(side: int, seed: int, density: float = 0.2) -> GridMap:
    """Obstacles strewn over a square; two opposite corners are free and joined."""
    rng = np.random.default_rng(seed)
    free = rng.random((side, side)) >= density
    free[:2, :2] = free[-2:, -2:] = True
    return GridMap(free, 1.0)


def corners(grid: GridMap) -> tuple[np.ndarray, np.ndarray]:
    """Middles of the first and the last cell."""
    first, last = grid.centres([[0, 0], np.subtract(grid.shape, 1)])
    return first, last


def skimage_cost(costs: np.ndarray, start: Cell, goal: Cell) -> float:
    """Cost of the way that route_through_array takes; it cuts corners."""
    searched, _ = MCP_Geometric(costs).find_costs([start], [goal])
    return float(searched[goal])


def graph_of(grid: GridMap) -> networkx.Graph:
    """Free cells joined to their neighbours; corners are cut."""
    graph, free = networkx.Graph(), grid.free
    for row, col in np.argwhere(free).tolist():
        for dr, dc in ((0, 1), (1, -1), (1, 0), (1, 1)):
            r, c = row + dr, col + dc
            if r < free.shape[0] and 0 <= c < free.shape[1] and free[r, c]:
                graph.add_edge((row, col), (r, c), weight=hypot(dr, dc))
    return graph


def octile(a: Cell, b: Cell) -> float:
    """Length of the way on an empty map [cells]."""
    far, near = sorted((abs(a[0] - b[0]), abs(a[1] - b[1])), reverse=True)
    return far + (sqrt(2.0) - 1.0) * near


def way_length(cells: list[Cell]) -> float:
    """Length of a way of cells [cells]."""
    return float(np.hypot(*np.diff(np.array(cells), axis=0).T).sum())


def on_the_field() -> None:
    """The game field in cells of 1 cm, inflated by the robot's radius."""
    grid = inflate(field.obstacle_map(0.01), RADIUS)
    start, goal = (tuple(grid.cells(point).tolist()) for point in (START, GOAL))
    costs = np.where(grid.free, 1.0, -1.0)
    weights = np.where(grid.free, 1.0, np.inf).astype(np.float32)
    cut = astar(grid, START, GOAL, cut_corners=True)
    assert abs(skimage_cost(costs, start, goal) - cut.length / 0.01) < 1e-6
    moves = pyastar2d.astar_path(weights, start, goal, allow_diagonal=True)
    assert way_length(moves) >= cut.length / 0.01 - 1e-6
    replanner, half = Replanner(GOAL), len(cut.xy) // 2
    free = grid.free.copy()
    row, col = astar(grid, START, GOAL).cells[half]
    free[row - 10 : row + 10, col - 10 : col + 10] = False
    changed, here = GridMap(free, 0.01, grid.origin), astar(grid, START, GOAL).xy[half // 2]

    def mend() -> None:  # a box appears, and goes again
        replanner.plan(changed, here)
        replanner.plan(grid, here)

    def start_anew() -> None:
        astar(changed, here, GOAL)
        astar(grid, here, GOAL)

    times = medians(
        {
            "astar": lambda: astar(grid, START, GOAL),
            "astar, corners cut": lambda: astar(grid, START, GOAL, cut_corners=True),
            "astar, weight 2.5": lambda: astar(grid, START, GOAL, weight=2.5),
            "anytime_astar, four weights": lambda: list(anytime_astar(grid, START, GOAL)),
            "two plans of a Replanner": mend,
            "two new searches instead": lambda: (
                astar(changed, here, GOAL),
                astar(grid, here, GOAL),
            ),
            "pyastar2d (fewest moves)": lambda: pyastar2d.astar_path(
                weights, start, goal, allow_diagonal=True
            ),
            "skimage MCP_Geometric": lambda: skimage_cost(costs, start, goal),
        },
        REPEATS,
    )
    print(f"field, {grid.shape[0]} x {grid.shape[1]} cells, {int(grid.free.sum())} free")
    print(f"  costs equal skimage's: {cut.length / 0.01:.3f} cells with corners cut")
    report(times)
    ratio("share of pyastar2d's time", times, "astar", "pyastar2d (fewest moves)", 1 / 3)
    ratio("share of skimage's time", times, "astar, corners cut", "skimage MCP_Geometric", 1 / 8)


def on_random_maps() -> None:
    """500 x 500 cells, a fifth of them blocked."""
    grid = random_map(500, seed=1)
    ends, goal = corners(grid), tuple(np.subtract(grid.shape, 1).tolist())
    graph = graph_of(grid)
    peer_map = Grid(matrix=grid.free.astype(int).tolist())
    finder = AStarFinder(diagonal_movement=DiagonalMovement.only_when_no_obstacle)

    def networkx_way() -> list[Cell]:
        return networkx.astar_path(graph, (0, 0), goal, heuristic=octile, weight="weight")

    def pathfinding_way() -> list:
        peer_map.cleanup()
        way, _ = finder.find_path(peer_map.node(0, 0), peer_map.node(*goal[::-1]), peer_map)
        return way

    strict, cut = astar(grid, *ends), astar(grid, *ends, cut_corners=True)
    assert abs(way_length(networkx_way()) - cut.length) < 1e-6
    assert abs(way_length([(node.y, node.x) for node in pathfinding_way()]) - strict.length) < 1e-6
    times = medians(
        {
            "astar": lambda: astar(grid, *ends),
            "astar, corners cut": lambda: astar(grid, *ends, cut_corners=True),
            "networkx (corners cut)": networkx_way,
            "pathfinding": pathfinding_way,
        },
        REPEATS,
    )
    print("\nrandom map, 500 x 500 cells, a fifth of them blocked")
    print(f"  costs equal networkx's {cut.length:.3f} and pathfinding's {strict.length:.3f} cells")
    report(times)
    ratio("share of networkx's time", times, "astar, corners cut", "networkx (corners cut)", 0.01)
    ratio("share of pathfinding's time", times, "astar", "pathfinding", 0.01)


def growth() -> None:
    """From 500 to 4000 cells a side: time and memory."""
    print("\nrandom maps, a fifth of the cells blocked: growth")
    for side in (500, 1000, 2000, 4000):
        grid = random_map(side, seed=side)
        ends = corners(grid)
        plan = astar(grid, *ends)
        tracemalloc.start()
        astar(grid, *ends)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        seconds = medians({"astar": lambda: astar(grid, *ends)}, REPEATS)["astar"]  # noqa: B023
        print(
            f"  {side:4d} x {side:<4d} {seconds * 1e3:8.1f} ms   {plan.expanded:8d} cells,"
            f" {seconds / plan.expanded * 1e9:4.0f} ns each   {peak / grid.free.size:4.1f} bytes"
            " a cell of the map    wanted <= 16"
        )


def report(times: dict[str, float]) -> None:
    """One line per contender."""
    for name, seconds in times.items():
        print(f"  {name:34s} {seconds * 1e3:10.2f} ms")


def ratio(words: str, times: dict[str, float], ours: str, peer: str, wanted: float) -> None:
    """One line: our time over the peer's."""
    print(f"  {words:34s} {times[ours] / times[peer]:10.4f}       wanted <= {wanted:.3f}")


def main() -> None:
    """Print a time for each contender, then the ratios that matter."""
    print(f"A*, median of {REPEATS} repeats\n")
    on_the_field()
    on_random_maps()
    growth()


if __name__ == "__main__":
    main()

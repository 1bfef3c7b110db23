# %% [markdown]
# # 04 · Planning: the way over the field
#
# Boxes stand on the field. You find the shortest way past them, straighten it, round its bends, and
# plan anew when something stands in the way that no map knows.
#
# | | |
# |---|---|
# | Time | 4 hours |
# | You need | chapter 00, Python lists and dictionaries |
# | Points | 22: six functions, two numbers, one challenge |
# | Your robot gains | `inflate_square`, `astar`, `shorten_path`, `smooth_path` |

# %%
import heapq
import itertools
import math
import time

import numpy as np
from matplotlib.patches import Rectangle

from robocon_course import field, gridmap, planning, worlds
from robocon_course.exercises import answer, begin, check, hint, robot_parts, status
from robocon_course.files import data_file
from robocon_course.gridmap import GridMap
from robocon_course.robot import SIDE
from robocon_course.view import animate_search, draw_ways, explore, figure, pictures, plots, show

student = begin("planning", student=None)  # None: the number you gave in chapter 00
world = worlds.ways_world(student)
HALF = SIDE / 2  # m

# %% [markdown]
# ## 1. Where this part sits

# %%
show(
    pictures.draw_system(here="04"),
    "Planning stands between the mission's target and the path that chapter 05 follows: a map and "
    "two points go in, a way comes out.",
)

# %% [markdown]
# ## 2. See it work
#
# This is your field: your student number decides where boxes stand. The search spreads from the start.
# Pale cells come first, dark ones last. When it reaches the goal, the way is known.
#
# Black is not free. Grey is free, but too near for the middle of a robot 0.65 m wide.

# %%
room = gridmap.inflate_square(world.grid, HALF)
plan = planning.astar(room, world.start, world.goal, watch=True)
marks = {"start": world.start, "goal": world.goal}
show(
    animate_search(world.grid, plan, room=room, markers=marks),
    f"The search goes on from {plan.expanded} of {room.free.sum()} cells and finds the shortest way "
    "from the start zone to Area 3.",
)

# %% [markdown]
# ## 3. A map of cells
#
# The field is cut into cells. Each is free, or it is not. Everything else follows from that.
#
# | symbol | meaning | unit |
# |---|---|---|
# | `grid.free[row, col]` | True where nothing stands; row 0 at the smallest y | |
# | `grid.resolution` | side of a cell | m |
# | `grid.origin` | corner of cell (0, 0) with the smallest x and y | m, map |
# | `grid.cells(xy)`, `grid.centres(cells)` | from metres to cells and back | |
# | $g(n)$ `cost` | length of the best way found from the start to cell n | cells |
# | $h(n)$ | estimate of what is left from n to the goal | cells |
# | $f(n) = g(n) + h(n)$ | length of a way through n, as far as known | cells |
# | $w$ `weight` | how much the estimate counts | |
# | $\kappa$ `max_curvature` | one over the radius of a bend; section 9 | 1/m |
#
# **Row before column, y before x.** `xy` is in metres, x first. A cell is `(row, col)`: y first.

# %%
cell = world.grid.cells(world.start)
print(f"start {world.start} m lies in cell {tuple(cell.tolist())}, row first")
print(f"the middle of that cell is {world.grid.centres(cell).round(3)} m")
print(f"the map has {world.grid.shape} cells of {world.grid.resolution} m")

# %% [markdown]
# **Any map will do.** ROS robots keep maps as a picture and a YAML file. `load_map` reads them. The
# course's own field lies beside it in that form: load your own hall the same way.

# %%
loaded = gridmap.load_map(data_file("field/obstacles_5cm.yaml"))
same = np.array_equal(loaded.free, field.obstacle_map(0.05).free)
plain = planning.astar(loaded, world.start, world.goal, clearance=HALF)
print(f"from the file: {loaded.shape}, the same as the drawn field: {same}")
print(f"a way over the empty field: {plain.length:.2f} m")

# %% [markdown]
# ## 4. Room for the body
#
# A search moves a point. The robot is a square. The trick: let obstacles grow by half the robot,
# then its middle may be a point again.
#
# How do they grow? A round robot's obstacles grow by a disc. Ours is square and keeps its heading
# along the field. Look at a corner.

# %%
corner = gridmap.put_boxes(GridMap(np.ones((200, 220), dtype=bool), 0.01), [(0, 0, 1.0, 1.0)])
at = 1.0 + 0.34 * math.sqrt(0.5)
rooms = {"grown by a disc": gridmap.inflate(corner, HALF)}
rooms["grown by a square"] = gridmap.inflate_square(corner, HALF)

# %%
fig, panels = figure(8.2, 3.9, columns=2, sharey=True)
for ax, (title, grown) in zip(panels, rooms.items()):
    draw_ways(corner, room=grown, window=None, ax=ax)
    body = {"edgecolor": plots.WARN, "facecolor": "none", "linewidth": 2.2, "zorder": 4}
    ax.add_patch(Rectangle((at - HALF, at - HALF), SIDE, SIDE, **body))
    ax.plot(at, at, "o", color=plots.WARN, zorder=5)
    ax.set_title(f"{title}: {'free' if grown.is_free([at, at]) else 'not free'}")
show(
    fig,
    f"The robot's middle is 0.34 m from the corner of an obstacle. Grown by a disc the place counts "
    f"as free, and the body stands {1000 * (1.0 - at + HALF):.0f} mm in the obstacle. Grown by a "
    "square it is not free.",
)

# %% [markdown]
# So a blocked cell blocks all cells up to $n$ rows **and** $n$ columns away,
#
# $$n = \lceil \text{half} / \text{resolution} \rceil$$
#
# Two cells $n$ apart leave $n - 1$ cells between them. So the gap to a cell that stays free is at
# least half. 0.325 m are 6.5 cells: $n$ is 7. Subtract 1e-9 before you round up, or rounding costs a cell.
#
# The edge of the map counts like blocked cells: nobody knows what is outside.

# %% [markdown]
# ### Exercise: room for a square (3 points)
#
# A map cannot change. Make a new one: `GridMap(free, grid.resolution, grid.origin)`.


# %% exercise="planning.inflate_square"
def inflate_square(grid, half):
    """The map for the middle of a square robot that keeps its heading.

    grid : GridMap
    half : float, half the side of the robot [m]
    returns : GridMap
    """
    ### BEGIN SOLUTION
    n = math.ceil(half / grid.resolution - 1e-9)
    rows, cols = grid.shape
    padded = np.pad(~grid.free, n, constant_values=True)
    blocked = np.zeros(grid.shape, dtype=bool)
    for r in range(2 * n + 1):
        for c in range(2 * n + 1):
            blocked |= padded[r : r + rows, c : c + cols]
    return GridMap(~blocked, grid.resolution, grid.origin)
    ### END SOLUTION


# %% check="planning.inflate_square"
inflate_square = check("planning.inflate_square")

# %% [markdown]
# Your field, with room for your robot by your own part:

# %%
room = inflate_square(world.grid, HALF)
lost = 100 * (1 - room.free.sum() / world.grid.free.sum())
show(
    draw_ways(world.grid, room=room, markers=marks),
    f"Your field: {len(world.boxes)} boxes. {lost:.0f} % of the free cells are too near to something "
    "for the middle of the robot.",
)

# %% [markdown]
# ## 5. What is left, at least
#
# A search *expands* cells: it takes one, looks at its neighbours, and goes on from there. Dijkstra's
# search expands the cell with the smallest cost $g$. It spreads to all sides. A* adds what is left:
#
# $$f(n) = g(n) + h(n)$$
#
# Now cells towards the goal come first. But nobody knows what is left. $h$ is an estimate, made as
# if nothing stood in the way. To a goal $a$ rows and $b$ columns away:
#
# | estimate | formula | never more than what is left? |
# |---|---|---|
# | zero | 0 | yes: this is Dijkstra |
# | straight line | $\sqrt{a^2 + b^2}$ | yes |
# | octile | $\max(a, b) + (\sqrt 2 - 1) \min(a, b)$ | yes, and exact on an empty map |
# | Manhattan | $a + b$ | **no**: a diagonal step is $\sqrt 2$, it counts 2 |
#
# An estimate that is never more than what is left is **admissible**. Why does that matter? Say it is
# the goal's turn, with cost $C$. Every cell still waiting has $f \ge C$. With an admissible $h$ no way through one of
# them can be shorter than its $f$. So $C$ is the shortest. If $h$ is too large, this fails.

# %%
looks = {
    "zero": {"weight": 0.0},
    "straight line": {"heuristic": "euclidean"},
    "octile": {"heuristic": "octile"},
    "Manhattan": {"heuristic": "manhattan"},
}
fig, panels = figure(8.6, 4.7, columns=4, sharey=True)
found = {}
for ax, (name, how) in zip(panels, looks.items()):
    found[name] = planning.astar(room, world.start, world.goal, watch=True, **how)
    draw_ways(world.grid, {"reference": found[name].xy}, room=room, plan=found[name], ax=ax)
    ax.get_legend().remove()
    ax.set_title(f"{name}\n{found[name].expanded} cells")
    ax.set(xlabel="", ylabel="")
words = ", ".join(f"{name} {p.expanded} cells and {p.length:.2f} m" for name, p in found.items())
show(fig, f"The same way looked for with four estimates: {words}.")

# %% [markdown]
# Manhattan expands the fewest cells. On your field it may even find the shortest way. Here is a map
# on which it does not.

# %%
picture = """
#...........
...#.##.#...
...#..#.....
....#......#
..##....##..
..#........#
.....#......""".split()
small = GridMap(np.array([[c != "#" for c in line] for line in picture[::-1]]), 0.1)
ends = small.centres([(0, 0), (6, 11)])
short, long = (planning.astar(small, *ends, heuristic=h) for h in ("octile", "manhattan"))
ways = {"reference: octile": short.xy, "wrong: Manhattan": long.xy}
show(
    draw_ways(small, ways, window=None, markers={"start": ends[0], "goal": ends[1]}),
    f"With the octile distance the way is {short.length:.3f} m long, with Manhattan {long.length:.3f} m: "
    f"{100 * (long.length / short.length - 1):.0f} % longer.",
)

# %% [markdown]
# ### Exercise: the octile distance (1 point)
#
# Go diagonally until you are level with the goal, then straight on.


# %% exercise="planning.octile_distance"
def octile_distance(cell, goal):
    """Length of the shortest way between two cells on an empty map.

    cell, goal : pairs of int (row, col)
    returns : float [cells]
    """
    ### BEGIN SOLUTION
    a, b = abs(goal[0] - cell[0]), abs(goal[1] - cell[1])
    return max(a, b) + (math.sqrt(2) - 1) * min(a, b)
    ### END SOLUTION


# %% check="planning.octile_distance"
octile_distance = check("planning.octile_distance")

# %% [markdown]
# ## 6. Which steps are open
#
# Eight neighbours, if they are free and in the map. A diagonal step passes between two more cells.
# If one of them is blocked, the step cuts its corner. If both are, it slips through where they
# meet. So **both** have to be free.

# %%
between = GridMap(np.array([[1, 1, 0, 1, 1], [1, 1, 0, 1, 1], [1, 1, 1, 0, 0]], dtype=bool), 1.0)
between = GridMap(np.vstack([between.free, np.ones((1, 5), dtype=bool)]), 1.0)
fig, panels = figure(8.2, 3.4, columns=2, sharey=True)
counts = []
for ax, cut in zip(panels, (False, True)):
    steps = planning.neighbours(between, (2, 2), cut_corners=cut)
    draw_ways(between, window=None, ax=ax)
    for to, cost in steps:
        line = np.array([between.centres((2, 2)), between.centres(to)])
        colour = plots.MINE if cost == 1 else plots.REFERENCE
        ax.annotate("", line[1], line[0], arrowprops={"color": colour, "arrowstyle": "->", "lw": 2})
    ax.set_title("corners cut" if cut else "both cells beside are free")
    counts.append(len(steps))
show(fig, f"From one cell {counts[0]} steps are open, and {counts[1]} if corners may be cut.")

# %% [markdown]
# ### Exercise: neighbours (3 points)
#
# A straight step costs 1, a diagonal one $\sqrt 2$. Beware of the edge: `grid.free[-1]` is the
# *last* row.


# %% exercise="planning.neighbours"
def neighbours(grid, cell):
    """The cells to which one step leads, and what it costs.

    grid : GridMap
    cell : pair of int (row, col), free
    returns : list of ((row, col), cost), cost in cells
    """
    ### BEGIN SOLUTION
    (row, col), found = cell, []
    for dr in (-1, 0, 1):
        for dc in (-1, 0, 1):
            to = row + dr, col + dc
            inside = 0 <= to[0] < grid.shape[0] and 0 <= to[1] < grid.shape[1]
            if (dr, dc) != (0, 0) and inside and grid.free[to]:
                if grid.free[to[0], col] and grid.free[row, to[1]]:
                    found.append((to, math.sqrt(2) if dr and dc else 1.0))
    return found
    ### END SOLUTION


# %% check="planning.neighbours"
neighbours = check("planning.neighbours")

# %% [markdown]
# ## 7. A*
#
# Keep a heap of cells that wait, sorted by $f$. Then, again and again:
#
# 1. Take the cell with the smallest $f$. Is it the goal? Then you are done.
# 2. For each of its neighbours: is the way through this cell cheaper than any before?
# 3. If so, note the new cost and where you came from, and put the neighbour on the heap.
#
# A cell may wait several times. Its cheapest entry comes out first; later ones may be skipped. In the
# end go back from the goal along "where you came from". The start came from nowhere: it has no entry.
# That part is given:


# %%
def way_back(came_from, last):
    """The cells from the start to the last one, along the steps that led there."""
    way = [last]
    while way[-1] in came_from:
        way.append(came_from[way[-1]])
        if len(way) > len(came_from) + 1:
            raise ValueError("came_from leads round in a circle; has the start an entry?")
    return way[::-1]


# %%
queue = []
for entry in [(7.8, (3, 4)), (5.2, (9, 1)), (6.0, (2, 2))]:
    heapq.heappush(queue, entry)  # a pair is sorted by its first number
print("comes out first:", heapq.heappop(queue))

# %% [markdown]
# ### Exercise: A* (5 points)
#
# `grid` is room for the robot's middle already. Start and goal are in metres:
# `tuple(grid.cells(start).tolist())` is a cell that a dictionary can take. At the end
# `planning.plan_through(grid, cells, expanded)` makes the plan; `expanded` is the number of cells
# from which the search went on, with the goal or without.
#
# If start or goal is not free, or no way leads there, raise
# `planning.NoPathError("a sentence that says why", "enclosed")`.


# %% exercise="planning.astar"
def astar(grid, start, goal):
    """The shortest way from start to goal.

    grid : GridMap, inflated
    start, goal : (2,) arrays [m, map]
    returns : planning.Plan; raises planning.NoPathError where there is no way
    """
    ### BEGIN SOLUTION
    first, last = (tuple(grid.cells(point).tolist()) for point in (start, goal))
    cost, came_from, done = {first: 0.0}, {}, set()
    queue = [(0.0, first)] if grid.is_free(start) else []
    while queue:
        cell = heapq.heappop(queue)[1]
        if cell == last:
            return planning.plan_through(grid, way_back(came_from, last), len(done))
        done.add(cell)
        for to, step in neighbours(grid, cell):
            new = cost[cell] + step
            if new < cost.get(to, math.inf):
                cost[to], came_from[to] = new, cell
                heapq.heappush(queue, (new + octile_distance(to, last), to))
    raise planning.NoPathError("no way leads from start to goal", "enclosed")
    ### END SOLUTION


# %% check="planning.astar"
astar = check("planning.astar")

# %% [markdown]
# The last case was the game field with boxes, and the check told you how long your search took.
# Python is slow and yours is good enough: the robot plans once, and drives for ten seconds. How
# fast can it be? The course's search is the same idea, compiled, with whole numbers for costs and
# stacks instead of the heap.

# %%
for name, search in {"yours": astar, "the course's": planning.astar}.items():
    begun = time.perf_counter()
    way = search(room, world.start, world.goal)
    spent = 1000 * (time.perf_counter() - begun)
    print(f"{name:13s} {way.expanded:6d} cells, {spent:7.1f} ms")

# %% [markdown]
# ### Your number: the way over your field (1 point)
#
# How long is the shortest way of your robot from `world.start` to `world.goal` on `world.grid`? In
# metres.

# %% answer="planning.own_length"
answer(
    "planning.own_length",
    ### BEGIN SOLUTION
    astar(inflate_square(world.grid, HALF), world.start, world.goal).length,
    ### END SOLUTION
)

# %% [markdown]
# ### Your number: the largest robot (1 point)
#
# From the top of ramp 1, `worlds.RAMP_TOP`, to `world.goal`: what is the largest half side, in
# whole centimetres, for which there still is a way? Answer in metres: 0.33, for instance.
#
# Cells of 5 cm are too coarse for this question. `world.fine` has cells of 1 cm. It is 25 times as
# large, so this takes the course's compiled parts:


# %%
def passes(half):
    """Whether a robot with this half side gets from ramp 1 to the goal."""
    place = gridmap.inflate_square(world.fine, half)
    try:
        planning.astar(place, worlds.RAMP_TOP, world.goal)
    except planning.NoPathError:
        return False
    return True


print("half 0.33 m passes:", passes(0.33))

# %% answer="planning.own_gap"
answer(
    "planning.own_gap",
    ### BEGIN SOLUTION
    max(cm for cm in range(30, 60) if passes(cm / 100)) / 100,
    ### END SOLUTION
)

# %% [markdown]
# ## 8. Sooner, but longer
#
# Let the estimate count more: $f = g + w\,h$ with $w > 1$. The search runs straighter to the goal,
# and looks at fewer cells. Its way may be longer, but at most about $w$ times.
#
# **Task.** Which is the smallest weight with which your way gets longer? What do weights below 1
# do?


# %%
def draw_weight(weight):
    """The search on your field with one weight."""
    found = planning.astar(room, world.start, world.goal, weight=weight, watch=True)
    fig, ax = figure(3.6, 5.6)  # small: the slider stays in sight below it
    draw_ways(world.grid, {"reference": found.xy}, room=room, plan=found, markers=marks, ax=ax)
    ax.get_legend().remove()
    ax.set_title(f"{found.expanded} cells, {found.length:.2f} m")
    one = next(planning.anytime_astar(room, world.start, world.goal, weights=[weight]))
    return fig, (
        f"Weight {weight:g}: {found.expanded} cells, a way of {found.length:.2f} m. It is at most "
        f"{one.bound:.2f} times as long as the shortest, and really {found.length / plan.length:.3f} times."
    )


explore(draw_weight, weight=(0.0, 5.0, 0.25, 1.0))

# %% [markdown]
# **A way soon, then better ones.** Search with a large weight first, then with smaller ones, for
# as long as there is time. After each search there is a way, and a *bound*: it is at most so many
# times as long as the shortest. The thesis about the winning robot plans like this.

# %%
weights = (3.0, 2.0, 1.6, 1.3, 1.1)
rounds = list(planning.anytime_astar(room, world.start, world.goal, weights=weights))
fig, (ratio, effort) = figure(8.2, 2.9, columns=2)
names = [f"w = {one.weight:g}" for one in rounds]
ratio.plot(names, [one.bound for one in rounds], "o-", color=plots.WARN, label="bound")
real = [one.plan.length / plan.length for one in rounds]
ratio.plot(names, real, "o-", color=plots.REFERENCE, label="really")
ratio.set_title("way / shortest way")
ratio.legend()
effort.bar(names, [one.expanded for one in rounds], color=plots.MINE, width=0.5)
effort.set_title("cells looked at")
words = "; ".join(
    f"{n}: at most {o.bound:.2f} times, really {r:.3f}" for n, o, r in zip(names, rounds, real)
)
show(fig, f"Repeated search with falling weight. {words}.")

# %% [markdown]
# ## 9. From cells to a way that can be driven
#
# A*'s way has a point in every cell, and eight directions. Three steps mend that.
#
# **Thin.** A point every so often is enough to drive along. How far along the way does each point
# lie? Call it $s$. Then $\lfloor s / \text{spacing} \rfloor$ is the number of its piece. Keep the
# first point of every piece, and the last point of the way. Thinning knows no map: it cuts corners
# by up to half the spacing.

# %% [markdown]
# ### Exercise: thin a way (1 point)
#
# Add 1e-9 before you round down: what rounding took from the sum of many steps must not cost a point.


# %% exercise="planning.thin_path"
def thin_path(xy, spacing):
    """The first point of every piece of a way, and the last of all.

    xy : (n, 2) array [m, map]
    spacing : float, length of a piece along the way [m]
    returns : (m, 2) array [m, map]
    """
    ### BEGIN SOLUTION
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(xy, axis=0).T)))
    keep = np.diff(np.floor(along / spacing + 1e-9), prepend=-1) > 0
    keep[-1] = True
    return xy[keep]
    ### END SOLUTION


# %% check="planning.thin_path"
thin_path = check("planning.thin_path")

# %% [markdown]
# **Shorten.** Stand on a point. Which is the last one that you see? Drive straight there, and look
# again. On the inflated map a line that touches only free cells keeps the robot clear of everything.
# `planning.line_of_sight(grid, a, b)` says whether it does.

# %% [markdown]
# ### Exercise: shorten a way (3 points)
#
# Both ends stay. The neighbour on the way counts as in sight in any case.


# %% exercise="planning.shorten_path"
def shorten_path(grid, xy):
    """Straight legs, as long as can be seen.

    grid : GridMap, inflated
    xy : (n, 2) array [m, map]
    returns : (m, 2) array [m, map], with the same first and last point
    """
    ### BEGIN SOLUTION
    kept, at = [xy[0]], 0
    while at < len(xy) - 1:
        to = len(xy) - 1
        while to > at + 1 and not planning.line_of_sight(grid, xy[at], xy[to]):
            to -= 1
        kept.append(xy[to])
        at = to
    return np.array(kept)
    ### END SOLUTION


# %% check="planning.shorten_path"
shorten_path = check("planning.shorten_path")

# %% [markdown]
# **Smooth.** At a sharp bend the robot has to stop: its wheels cannot turn in no time. A bend of
# radius $r$ has the curvature $\kappa = 1/r$, and may be driven at
#
# $$v = \sqrt{a / \kappa}$$
#
# with $a$ the sideways acceleration that the tyres bear. But bends stand right at an obstacle: there
# is no room inside. So the way has to swing out before it turns in. `planning.smooth_path` does
# that; the challenge asks for your own.

# %%
BEND = 5.0  # 1/m: no bend tighter than 0.2 m
straight = shorten_path(room, plan.xy)
smooth = planning.smooth_path(room, straight, BEND)
stages = {"raw: A*": plan.xy, "shortened": straight, "reference: smooth": smooth}
for name, xy in stages.items():
    taken = worlds.driving_time(xy, BEND)
    print(
        f"{name:18s} {len(xy):4d} points, {planning.path_length(xy):6.2f} m, {taken:5.1f} s to drive"
    )
show(
    draw_ways(world.grid, stages, room=room, markers=marks),
    f"A*'s way has {len(plan.xy)} points and takes {worlds.driving_time(plan.xy, BEND):.1f} s to drive. "
    f"Shortened it has {len(straight)} points and takes {worlds.driving_time(straight, BEND):.1f} s, "
    f"smooth {worlds.driving_time(smooth, BEND):.1f} s.",
)

# %% [markdown]
# The tightest bend, enlarged:

# %%
sharp = straight[1 + np.argmax(planning.path_curvature(straight)[1:-1])]
near = (sharp[0] - 0.8, sharp[0] + 0.8, sharp[1] - 0.6, sharp[1] + 0.6)
fig = draw_ways(world.grid, stages, room=room, window=near)
bends = planning.path_curvature(smooth)
show(
    fig,
    f"Near ({sharp[0]:.2f}, {sharp[1]:.2f}) m: A*'s steps, the shortened way with its kink, and the "
    f"smooth one, which bends by at most {bends.max():.2f} per metre.",
)

# %% [markdown]
# ## 10. What no map knows
#
# Somebody left boxes on the field. Your map does not show them. The robot sees 1.5 m far, all
# around. What it has not seen counts as free:
#
# look → know more → does something stand in the plan? → plan from here → one cell on
#
# Every obstacle that stops it is one more that it knows. So at last it arrives, or knows that there
# is no way. In the figure rings show where it planned anew.


# %%
def square_room(grid):
    """Where the robot's middle may be."""
    return inflate_square(grid, HALF)


# %%
journey = planning.travel(
    world.truth, world.start, world.goal, reach=1.5, known=world.grid, room=square_room
)
first, driven = journey.legs[0].plan, planning.path_length(journey.xy)
turns = [leg.at for leg in journey.legs[1:]]
show(
    draw_ways(
        world.truth,
        {"raw: first plan": first.xy, "reference: driven": journey.xy},
        room=square_room(world.grid),
        markers={"": turns} if turns else marks,
    ),
    f"Through {len(world.hidden)} boxes that it does not know the robot plans anew {len(turns)} times, "
    f"and drives {driven:.2f} m instead of {first.length:.2f} m.",
)

# %% [markdown]
# **From nothing, or mended.** Each new plan could start from nothing. But most of the last search is
# still true. **D\* Lite** searches from the goal, keeps all costs, and mends only those that the new
# obstacle changed. `planning.Replanner` is it, and `travel` uses it.

# %%
anew = planning.travel(
    world.truth,
    world.start,
    world.goal,
    reach=1.5,
    known=world.grid,
    room=square_room,
    planner=lambda known, xy: planning.astar(square_room(known), xy, world.goal),
)
efforts = {
    "mended: D* Lite": [leg.plan.expanded for leg in journey.legs],
    "from nothing": [leg.plan.expanded for leg in anew.legs],
}
same_way = math.isclose(driven, planning.path_length(anew.xy), rel_tol=0.05)
print(f"ways of about the same length: {same_way}")

# %%
fig, ax = figure(7.5, 2.9)
for k, (name, cells) in enumerate(efforts.items()):
    colour = (plots.REFERENCE, plots.RAW)[k]
    ax.bar(np.arange(len(cells)) + 0.4 * k - 0.2, cells, 0.38, color=colour, label=name)
ax.set(xlabel="plan", title="cells looked at for each plan")
ax.set_xticks(np.arange(max(map(len, efforts.values()))))
ax.legend()
later = [np.mean(cells[1:] or [0]) for cells in efforts.values()]
show(
    fig,
    f"A plan after the first looks at {later[0]:.0f} cells on average when it is mended, and at "
    f"{later[1]:.0f} when A* starts from nothing.",
)

# %% [markdown]
# It does not always pay. Mending is cheap where little has changed and the goal is far. Where a
# whole passage is closed, most of what was known is wrong, and a new A* may be cheaper.

# %% [markdown]
# **Ten times.** A thesis let its robot run ten times through obstacles it did not know. It arrived ten
# times. Ten fields for yours; it knows only the empty one:

# %%
fig, panels = figure(8.2, 6.6, columns=5, rows=2, sharex=True, sharey=True)
arrived, replans = 0, []
for k, ax in enumerate(panels.flat):
    boxes = worlds.passable_field(worlds.generator(student, "ten runs", str(k)))
    known = field.obstacle_map(0.05)
    run = planning.travel(boxes, world.start, world.goal, reach=1.5, known=known, room=square_room)
    draw_ways(boxes, {"reference": run.xy}, ax=ax)
    ax.get_legend().remove()
    arrived += np.allclose(run.xy[-1], boxes.centres(boxes.cells(world.goal)))
    replans.append(len(run.legs) - 1)
    ax.set(xlabel="", ylabel="", title=f"{replans[-1]} new plans")
show(
    fig,
    f"{arrived} of 10 runs arrive. The robot planned anew {min(replans)} to {max(replans)} times.",
)

# %% [markdown]
# ## 11. Break it
#
# Mistakes that real teams make. How much of each planned way has no room for the robot? A weight
# that is too large keeps its room, and takes its time.


# %%
def without_room(xy):
    """Share of a way on which the body stands in something [%]."""
    fine = gridmap.inflate_square(world.fine, HALF)
    return 100 * (1 - fine.is_free(planning.resample_path(xy, 0.02)).mean())


def plan_on(grid, half=HALF):
    """The way that comes of a wrong map, or of a wrong size."""
    place = gridmap.inflate_square(grid, half)
    ends = (planning.nearest_free(place, point) for point in (world.start, world.goal))
    return planning.astar(place, *ends).xy


# %%
free, cm5, origin = world.grid.free, world.grid.resolution, world.grid.origin
broken = {
    "all in order": plan_on(world.grid),
    "size forgotten": plan_on(world.grid, 0.0),
    "a disc": planning.astar(world.grid, world.start, world.goal, clearance=HALF).xy,
    "map one cell off": plan_on(GridMap(free, cm5, (origin[0] + cm5, origin[1]))),
    "boxes forgotten": plan_on(field.obstacle_map(0.05)),
    "thinned to 1 m": planning.thin_path(plan.xy, 1.0),
    "weight 20": planning.astar(room, world.start, world.goal, weight=20.0).xy,
}
for name, xy in broken.items():
    print(f"{name:17s} {planning.path_length(xy):6.2f} m, {without_room(xy):5.1f} % without room")

# %%
fig, panels = figure(8.6, 4.5, columns=4, sharey=True)
chosen = ("size forgotten", "a disc", "map one cell off", "boxes forgotten")
for ax, name in zip(panels, chosen):
    draw_ways(world.grid, {"wrong": broken[name]}, room=room, ax=ax)
    ax.get_legend().remove()
    ax.set(xlabel="", ylabel="", title=name)
words = ", ".join(f"{name} {without_room(broken[name]):.0f} %" for name in chosen)
show(fig, f"Four ways that the robot cannot drive. Share without room: {words}.")

# %% [markdown]
# **y down.** Pictures count rows from above. A map read like that is upside down, and so is the plan:

# %%
flipped = gridmap.inflate_square(GridMap(free[::-1], cm5, origin), HALF)
try:
    planning.astar(flipped, world.start, world.goal)
    print("there is a way, and it is nonsense")
except planning.NoPathError as refusal:
    print(f"{refusal.reason}: {refusal}")

# %% [markdown]
# Where a search refuses, that is luck. Draw the map once, with the start on it.
#
# **Start without room.** The robot was pushed against the fence. Its middle stands in a cell that is not
# free, and no way leads out of it. `nearest_free` says where to go first.

# %%
pushed = (0.2, 0.35)
try:
    astar(room, pushed, world.goal)
except planning.NoPathError as refusal:
    out = planning.nearest_free(room, pushed)
    print(f"NoPathError: {refusal}")
    print(f"first to {out.round(3)} m, then {astar(room, out, world.goal).length:.2f} m on")

# %% [markdown]
# **Corners cut.** Two boxes stand corner to corner. A search that cuts corners drives through between
# them.

# %%
touching = [(0.6, 0.0, 1.2, 0.9), (1.2, 0.9, 1.8, 2.0)]
gate = gridmap.put_boxes(GridMap(np.ones((20, 26), dtype=bool), 0.1), touching)
places = [(0.35, 1.75), (2.25, 0.25)]
cut = planning.astar(gate, *places, cut_corners=True)
try:
    fair = f"there is one of {planning.astar(gate, *places).length:.2f} m"
except planning.NoPathError:
    fair = "there is none"
show(
    draw_ways(gate, {"wrong: corners cut": cut.xy}, window=None),
    f"With corners cut a way of {cut.length:.2f} m leads through between two boxes that touch. "
    f"Without, {fair}.",
)

# %% [markdown]
# ## 12. Check the source
#
# **h from the start.** Two theses describe $h$ as the distance from the *start*. Let us try. The
# search below is yours in small, with $h$ left open.


# %%
def looked_at(h):
    """Cells from which A* goes on, and the length of its way [m], for an estimate h."""
    first, last = (tuple(room.cells(point).tolist()) for point in (world.start, world.goal))
    cost, queue, done = {first: 0.0}, [(0.0, first)], set()
    while last not in done:
        cell = heapq.heappop(queue)[1]
        if cell not in done:
            done.add(cell)
            for to, step in planning.neighbours(room, cell):
                if cost[cell] + step < cost.get(to, math.inf):
                    cost[to] = cost[cell] + step
                    heapq.heappush(queue, (cost[to] + h(to, first, last), to))
    return len(done), cost[last] * room.resolution


# %%
estimates = {
    "h to the goal": lambda cell, first, last: planning.octile_distance(cell, last),
    "no h": lambda cell, first, last: 0.0,
    "h from the start": lambda cell, first, last: planning.octile_distance(cell, first),
}
for name, h in estimates.items():
    cells, length = looked_at(h)
    print(f"{name:17s} {cells:6d} cells, {length:.2f} m")

# %% [markdown]
# As printed the way comes out right. But the search looks at more cells than without any $h$: it holds back
# the cells that are far from the start. Both programs use the distance to the goal; only the texts are wrong.
#
# **Manhattan.** The thesis offers Manhattan or straight-line distance, and drives diagonally. How much
# longer do ways get? On forty fields with boxes, and on forty maps with a quarter of their cells
# blocked:


# %%
def too_long(place, start, goal):
    """How much longer the way with Manhattan is [%]; not a number where there is none."""
    try:
        right = planning.astar(place, start, goal)
    except planning.NoPathError:
        return math.nan
    wrong = planning.astar(place, start, goal, heuristic="manhattan")
    return 100 * (wrong.length / right.length - 1)


def scattered(rng):
    """A map of 40 by 40 cells, a quarter of them blocked, and two of its corners."""
    place = GridMap(rng.uniform(size=(40, 40)) > 0.25, 0.1)
    ends = (planning.nearest_free(place, corner) for corner in ([0.0, 0.0], [4.0, 4.0]))
    return place, *ends


# %%
excess = {"fields with boxes": [], "scattered cells": []}
for k in range(40):
    rng = worlds.generator(student, "Manhattan", str(k))
    place = gridmap.inflate_square(worlds.passable_field(rng), HALF)
    excess["fields with boxes"].append(too_long(place, world.start, world.goal))
    while math.isnan(value := too_long(*scattered(rng))):
        pass  # no way there: another map
    excess["scattered cells"].append(value)
fig, panels = figure(8.2, 2.5, columns=2, sharey=True)
words = []
for ax, (name, values) in zip(panels, excess.items()):
    values = np.sort(values)
    ax.bar(range(len(values)), values, color=plots.WARN)
    ax.set(title=f"{name}: longer by [%]", xlabel="map, sorted", xlim=(-1, 40))
    words.append(f"{name}: {np.sum(values > 0.01)} of 40, by up to {values.max():.1f} %")
show(fig, f"How often Manhattan misses the shortest way. {'; '.join(words)}.")

# %% [markdown]
# On the field it is rarely wrong, and so nobody noticed.

# %% [markdown]
# **14 for 10√2.** The other thesis counts 10 for a straight step and 14 for a diagonal one: whole
# numbers are fast. 1.4 is 1 % less than $\sqrt 2$. So of two ways it may take the wrong one, but not
# by more than 1 %. The course counts whole numbers, too, but larger ones: 1 311 738 121 and
# 1 855 077 841.

# %%
ratio = 1_855_077_841 / 1_311_738_121
near = abs(ratio / math.sqrt(2) - 1) < 1e-15
print(f"14 / 10 is off by {100 * (1 - 1.4 / math.sqrt(2)):.2f} %, ours by less than 1e-15: {near}")

# %% [markdown]
# **Eight directions.** Its robot drives from cell to cell. Published: 4.8 % error in distance, 4.34 %
# in heading, up to one cell off. How much longer than the straight line
# are ways in eight directions, on an empty floor?

# %%
heading = np.linspace(0.0, np.pi / 4, 1001)
longer = 100 * (np.cos(heading) + (math.sqrt(2) - 1) * np.sin(heading) - 1)
print(f"eight directions: {longer.mean():.1f} % longer on average, {longer.max():.1f} % at most")

# %% [markdown]
# **Command words.** It is steered by words: `M4` four cells ahead, `Kr45` turn 45° left (*kiri*), `Kn90`
# turn 90° right (*kanan*), `F` finish. Your plan in its language:


# %%
def command_words(cells):
    """A way as the words of the thesis; the robot looks along +x first."""
    words, facing = [], 0
    for dr, dc in np.diff(cells, axis=0).tolist():
        angle = round(math.degrees(math.atan2(dr, dc)))
        turn = (angle - facing + 180) % 360 - 180
        if turn:
            words.append(f"{'Kr' if turn > 0 else 'Kn'}{abs(turn)}")
        if turn or not words:
            words.append("M0")
        words[-1] = f"M{int(words[-1][1:]) + 1}"
        facing = angle
    return [*words, "F"]


print(" ".join(command_words(plan.cells)))

# %% [markdown]
# ## 13. Link-up: your parts in the robot
#
# Three rungs. *Ideal*: the empty field. *Real*: your own boxes. *Rough*: boxes that no map knows.
# Each runs once on the course's parts and once on yours, as far as they were accepted.


# %%
def prepare(parts, grid):
    """From a map to a way that can be driven: room, A*, shortened, smooth."""
    place = parts.inflate_square(grid, HALF)
    found = parts.astar(place, np.array(world.start), np.array(world.goal))
    short = parts.shorten_path(place, np.array(found.xy))
    return parts.smooth_path(place, np.array(short), BEND)


def explore_on(parts):
    """A journey through the unknown on one's own parts."""
    return planning.travel(
        world.truth,
        world.start,
        world.goal,
        reach=1.5,
        known=world.grid,
        room=lambda grid: parts.inflate_square(grid, HALF),
        planner=lambda known, xy: parts.astar(parts.inflate_square(known, HALF), xy, world.goal),
    ).xy


# %%
course, mine = robot_parts("reference"), robot_parts("mixed")
print(f"Parts: {mine.label}")
rungs = {"ideal": field.obstacle_map(0.05), "real": world.grid, "rough": None}
results = {}
for name, grid in rungs.items():
    for parts in (course, mine):
        begun = time.perf_counter()
        xy = explore_on(parts) if grid is None else prepare(parts, grid)
        results.setdefault(name, []).append(xy)
        spent, far = time.perf_counter() - begun, planning.path_length(xy)
        print(f"{name:6s} {far:6.2f} m, found within {spent:5.2f} s on {parts.label}")

# %%
ours, yours = results["real"]
paths = {"reference": ours} | ({"mine": yours} if mine.mine else {})
show(
    draw_ways(world.grid, paths, room=room, markers=marks),
    f"The real rung on the course's parts and on yours ({mine.label}): {planning.path_length(ours):.2f} m "
    f"and {planning.path_length(yours):.2f} m.",
)

# %% [markdown]
# Chapter 05 drives along this way.
#
# ## 14. Challenge: bends that can be driven (4 points)
#
# A shortened way bends sharply at every corner of an obstacle, and there the robot has to stop. Round
# the bends: nowhere more than `max_curvature`, and every leg between two points in free cells.
#
# It is judged by the time that the robot takes, with 2 m/s, 2 m/s² along the way and 3 m/s² across
# it. Where a bend is tighter than allowed by a quarter, it stops. What the course's own way gains
# against the way as it comes counts as 100 %. Lose at most 40 % of it on the worst of three fields,
# and you earn all points; at most 85 %, and you earn half.
#
# Ideas: spread points over the legs, 5 cm apart, and keep the corners. Look where it bends too
# much (`planning.path_curvature`). Push that point inwards, and its neighbours half as much outwards.
# Ask for its bend as it is now, not as it was before its neighbour was pushed. Again and again. The push that is safe is given:


# %%
def moved(grid, points, k, step):
    """The points with number k moved by a step, if both its neighbours still see it."""
    if 0 < k < len(points) - 1:
        to = points[k] + step
        sees = planning.line_of_sight
        if sees(grid, points[k - 1], to) and sees(grid, to, points[k + 1]):
            points[k] = to
    return points


# %% exercise="planning.smooth_path"
def smooth_path(grid, xy, max_curvature):
    """The way with its bends rounded.

    grid : GridMap, inflated
    xy : (n, 2) array, a shortened way [m, map]
    max_curvature : float, one over the smallest radius [1/m]
    returns : (m, 2) array [m, map], with the same first and last point
    """
    ### BEGIN SOLUTION
    legs = list(itertools.pairwise(xy))
    counts = [math.ceil(math.dist(a, b) / 0.05) + 1 for a, b in legs]
    p = np.vstack([np.linspace(*leg, n)[:-1] for leg, n in zip(legs, counts)] + [xy[-1:]])
    for _ in range(3000):
        bend = planning.path_curvature(p)
        if bend.max() <= max_curvature:
            break
        for i in np.flatnonzero(bend > 0.98 * max_curvature):
            now = max(planning.path_curvature(p[i - 1 : i + 2])[1], 0.95 * max_curvature)
            push = (p[i - 1] - 2 * p[i] + p[i + 1]) * (1 - 0.95 * max_curvature / now) / 4
            p = moved(grid, p, i, 2 * push)
            p = moved(grid, moved(grid, p, i - 1, -push), i + 1, -push)
    return p
    ### END SOLUTION


# %% check="planning.smooth_path"
smooth_path = check("planning.smooth_path")

# %%
own = smooth_path(room, straight, BEND)
fig, (before, after) = figure(8.2, 3.0, columns=2, sharey=True)
for ax, (name, xy) in zip((before, after), {"shortened": straight, "smooth": own}.items()):
    even = planning.resample_path(xy, 0.05)
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(even, axis=0).T)))
    ax.plot(along, planning.path_curvature(even), color=plots.MINE, linewidth=1.2)
    ax.axhline(BEND, color=plots.TRUTH, linestyle=":")
    ax.set(title=f"{name}: bend [1/m]", xlabel="along the way [m]")
show(
    fig,
    f"Bends along your way, before and after. It takes {worlds.driving_time(straight, BEND):.1f} s "
    f"shortened, and {worlds.driving_time(own, BEND):.1f} s smooth.",
)

# %% [markdown]
# ## 15. Summary
#
# - Let obstacles grow by the body, and plan for a point. A square grows squares.
# - $f = g + h$. With an $h$ that is never too large, the way is the shortest.
# - Eight neighbours need the octile distance; Manhattan is too much.
# - A weight above 1 finds sooner what may be longer, and says by how much.
# - Cells, then straight legs, then bends that can be driven.
# - What is not known counts as free, until it is seen. Then plan from here.
#
# **Ask yourself.** Why may $h$ be too small, but not too large? Why does a disc not do for a square
# robot, and when does it? Which cells does Dijkstra look at that A* does not? Why can a mended plan
# be cheaper than a new one? What happens to your way if the map is one cell off?
#
# ## Glossary
#
# | English | Bahasa Indonesia |
# |---|---|
# | grid map, cell | peta grid, sel |
# | obstacle | rintangan |
# | inflation | penggelembungan rintangan |
# | shortest way | jalur terpendek |
# | heuristic, estimate | heuristik, taksiran |
# | admissible | dapat diterima (admisibel) |
# | cost | biaya |
# | heap, priority queue | antrean prioritas |
# | to expand a cell | membuka sel |
# | line of sight | garis pandang |
# | curvature | kelengkungan |
# | to plan anew | merencanakan ulang |
#
# ## Reading
#
# P. Hart, N. Nilsson, B. Raphael, *A Formal Basis for the Heuristic Determination of Minimum Cost
# Paths*, 1968: A* itself. M. Likhachev, G. Gordon, S. Thrun, *ARA\**, 2003: the falling weight.
# S. Koenig, M. Likhachev, *D\* Lite*, 2002: the mended plan.
#
# Sources of the published numbers: the thesis on a swerve-drive robot of Universitas Negeri
# Yogyakarta, 2024, chapter on A*; and the master thesis on a landmark robot with dynamic A*, Institut
# Teknologi Sepuluh Nopember, 2015.
#
# ## Where you are

# %%
status()

# %% [markdown]
# # 02 · Odometry: where is the robot?
#
# Three small wheels without a motor roll along and count.
# You turn their counts into a pose: where the robot stands, and where it looks.
#
# | | |
# |---|---|
# | Time | 4 hours |
# | You need | chapters 00 and 01, matrices with NumPy |
# | Points | 22: seven functions, two numbers, one challenge |
# | Your robot gains | `tick_changes`, `wheel_travel`, `wheel_matrix`, `body_deltas`, `integrate`, `body_velocity`, `calibrate_wheels` |

# %%
import numpy as np

from robocon_course import geometry, odometry, simulator, worlds
from robocon_course.autopilot import dead_reckoning
from robocon_course.exercises import answer, begin, check, hint, robot_parts, status
from robocon_course.robot import DEAD_WHEELS
from robocon_course.view import animate, explore, figure, pictures, plots, show

student = begin("odometry", student=None)  # None: the number you gave in chapter 00
world = worlds.odometry_world(student)

# %% [markdown]
# ## 1. Where this part sits

# %%
show(
    pictures.draw_system(here="02"),
    "Odometry comes after attitude and makes the pose that everything behind it needs.",
)

# %% [markdown]
# ## 2. See it work
#
# Somebody drove your robot twice around a square of 2 m, back to where it began.
# Here the course's own parts work out the path from the counts. Once they believe the sizes in the
# drawing, once those that a calibration found.


# %%
def path(wheels, counts):
    """Poses from counts, on the course's own parts."""
    travel = odometry.wheel_travel(wheels, counts)
    return odometry.integrate(odometry.body_deltas(wheels, travel))


def count(log):
    """Counts of each sample of a log, on the course's own parts."""
    return odometry.tick_changes(log.counters, worlds.BITS)


run_counts, spin_counts = count(world.run).sum(axis=0), count(world.spin).sum(axis=0)
calibrated = odometry.calibrate_wheels(
    DEAD_WHEELS, run_counts, worlds.RUN, spin_counts, worlds.SPIN
)

# %%
square, true_square = count(world.square), world.square.poses
drawn_path, good_path = path(DEAD_WHEELS, square), path(calibrated, square)
off = [1000 * np.hypot(*(p[-1] - true_square[-1])[:2]) for p in (drawn_path, good_path)]
show(
    plots.plot_paths(
        {"truth": true_square, "wrong sizes": drawn_path, "reference, calibrated": good_path},
        markers={"start": (0.0, 0.0)},
    ),
    f"Twice around a square of {worlds.SQUARE:g} m. With the drawing's sizes the path ends "
    f"{off[0]:.0f} mm from the truth, with calibrated sizes {off[1]:.0f} mm.",
)

# %% [markdown]
# The two sets of sizes differ by no more than 1 %. That is all the difference between the two paths.

# %% [markdown]
# ## 3. Three wheels that count
#
# A **dead wheel** has no motor. A spring presses it on the floor, it rolls along, and an encoder
# counts. It is an **omni wheel**: its rim is made of small rollers, so it slides sideways
# without a count.
#
# So each wheel feels one thing only: motion along its own direction. Left and right wheel feel
# forward. The rear wheel stands across, and feels sideways. A turn rolls all three.
#
# | symbol | meaning | unit, frame |
# |---|---|---|
# | `counters` | what the encoders' counters read | counts |
# | `ticks` | counts since the sample before | counts |
# | $r$ `radius` | radius of a wheel | m |
# | $N$ `ticks_per_turn` | counts in one turn of a wheel | – |
# | $d$ `travel` | how far a wheel rolled since the sample before | m |
# | $x_i, y_i$ `positions` | where wheel $i$ touches the floor | m, base |
# | $a_i$ `directions` | where wheel $i$ rolls to when it counts up | rad, base |
# | $A$ | wheel matrix, one row for each wheel | – |
# | $\Delta$ `deltas` | forward, left and turn since the sample before | m, m, rad; base |
# | $x, y, \theta$ `poses` | where the robot stands and looks | m, m, rad; map |
# | $h$ | half the turn of one sample | rad |
# | $\Delta t$ `dt` | time since the sample before | s |
#
# Base axes: x forward, y left. A left turn is positive.


# %%
def draw_motion(ax, motion, title):
    """The dead wheels from above, forward is up; how each moves, and what it counts."""
    (x, y), angles = DEAD_WHEELS.positions.T, DEAD_WHEELS.directions
    side, front = -y, x  # on paper: right and up
    along = 0.06 * np.array([-np.sin(angles), np.cos(angles)])
    ax.plot(*0.325 * np.array([[1, 1, -1, -1, 1], [1, -1, -1, 1, 1]]), color="0.8")
    ax.plot([side - along[0], side + along[0]], [front - along[1], front + along[1]], "0.2", lw=6)
    moves = (-motion[1] - motion[2] * x, motion[0] - motion[2] * y)
    arrows = {"scale": 1, "scale_units": "xy", "angles": "xy", "width": 0.012, "zorder": 3}
    ax.quiver(side, front, *moves, color=plots.MINE, **arrows)
    places = [(-0.5, -0.14), (0.5, -0.14), (0, -0.46)]
    for place, rolls in zip(places, DEAD_WHEELS.matrix @ motion):
        ax.text(*place, f"{rolls:+.2f} m".replace("-", "−"), ha="center", fontweight="bold")
    ax.set(xlim=(-0.72, 0.72), ylim=(-0.52, 0.42), aspect="equal", title=title)
    ax.set_axis_off()


# %%
motions = {"forward": (0.2, 0, 0), "to the left": (0, 0.2, 0), "left turn": (0, 0, 0.75)}
fig, panels = figure(8.2, 2.2, columns=3)
for ax, (name, motion) in zip(panels, motions.items()):
    draw_motion(ax, np.array(motion), name)
rolls = DEAD_WHEELS.matrix @ motions["left turn"]
show(
    fig,
    "Three motions from above, forward is up. An arrow shows where a wheel goes, a number what it "
    f"rolls. In a left turn of 0.75 rad left rolls {rolls[0]:+.2f}, right {rolls[1]:+.2f}, "
    f"rear {rolls[2]:+.2f} m: it goes to the right, since it stands behind the centre.",
)

# %% [markdown]
# ## 4. From counts to metres
#
# The microcontroller's counters have 16 bits. After 65535 comes 0, and before 0 comes 65535.
# A wheel is there again and again: less than 4 m of way fill the counter.

# %%
time = np.arange(len(world.square.counters)) * world.square.dt
mended = np.concatenate([[0], np.cumsum(square[:, 0])]) + world.square.counters[0, 0]
jumps = np.count_nonzero(np.abs(np.diff(world.square.counters[:, 0])) > 2 ** (worlds.BITS - 1))
fig, ax = figure(7.0, 3.0)
ax.plot(time, mended / 1000, color=plots.REFERENCE, label="changes added up")
ax.plot(time, world.square.counters[:, 0] / 1000, color=plots.RAW, label="the counter")
ax.set(xlabel="time [s]", ylabel="left wheel [thousand counts]")
ax.legend()
show(
    fig,
    f"The left wheel's counter on your square jumps {jumps} times at the end of its range. Its "
    f"changes, added up, go on to {mended[-1]:,} counts.",
)

# %% [markdown]
# From 65530 to 4 the wheel did not roll back by 65526. It rolled forward by 10.
# Of all changes that explain two readings, the right one is the **nearest to 0**.
# You solved this in chapter 00, for angles.

# %% [markdown]
# ### Exercise: counts between readings (2 points)
#
# It has to be right in both directions and for any number of bits.


# %% exercise="odometry.tick_changes"
def tick_changes(counters, bits):
    """Counts between the readings of counters that wrap around.

    counters : (n + 1, k) array of whole numbers, one row a sample
    bits : int, width of the counters
    returns : (n, k) array, the change nearest to 0 that explains two readings
    """
    ### BEGIN SOLUTION
    half = 2 ** (bits - 1)
    return (np.diff(counters, axis=0) + half) % (2 * half) - half
    ### END SOLUTION


# %% check="odometry.tick_changes"
tick_changes = check("odometry.tick_changes")

# %% [markdown]
# ### Exercise: travel (1 point)
#
# The encoder has 800 pulses a turn on two channels. Both edges of both channels count: 3200 counts.
# `wheels` is a `TrackingWheels` with the fields `positions`, `directions`, `radius` (one for each
# wheel) and `ticks_per_turn`. Use these four, here and in what follows.


# %% exercise="odometry.wheel_travel"
def wheel_travel(wheels, ticks):
    """How far each wheel rolled.

    wheels : odometry.TrackingWheels, k wheels
    ticks : (..., k) array of counts
    returns : (..., k) array [m]
    """
    ### BEGIN SOLUTION
    return 2 * np.pi * wheels.radius * ticks / wheels.ticks_per_turn
    ### END SOLUTION


# %% check="odometry.wheel_travel"
wheel_travel = check("odometry.wheel_travel")

# %%
step_mm = 1000 * wheel_travel(DEAD_WHEELS, np.ones(3))[0]
print(f"one count is {step_mm:.4f} mm; one metre is {1000 / step_mm:.0f} counts")

# %% [markdown]
# ## 5. The wheel matrix
#
# The body moves by $\Delta_x$ forward, $\Delta_y$ to the left, and turns by a small $\Delta_\theta$.
# A place $(x, y)$ on it then moves by
#
# $$\begin{pmatrix} \Delta_x - y\, \Delta_\theta \\ \Delta_y + x\, \Delta_\theta \end{pmatrix}$$
#
# A wheel there rolls only the part along its direction $(\cos a, \sin a)$:
#
# $$d = \cos a\, \Delta_x + \sin a\, \Delta_y + (x \sin a - y \cos a)\, \Delta_\theta$$
#
# One row for each wheel. The third entry is its **lever arm**: how far it rolls per radian of turn.
# It has a sign. Everything in this chapter goes wrong with the wrong one.

# %% [markdown]
# ### Exercise: the wheel matrix (2 points)
#
# Chapter 03 will drive with this matrix. Here it measures.


# %% exercise="odometry.wheel_matrix"
def wheel_matrix(positions, directions):
    """The linear map from a motion of the body to the travel of its wheels.

    positions : (k, 2) array [m, base]
    directions : (k,) array [rad, base], 0 is ahead, pi/2 is to the left
    returns : (k, 3) array; travel = matrix @ (forward, left, turn)
    """
    ### BEGIN SOLUTION
    x, y = positions[:, 0], positions[:, 1]
    c, s = np.cos(directions), np.sin(directions)
    return np.column_stack([c, s, x * s - y * c])
    ### END SOLUTION


# %% check="odometry.wheel_matrix"
wheel_matrix = check("odometry.wheel_matrix")

# %%
matrix = wheel_matrix(DEAD_WHEELS.positions, DEAD_WHEELS.directions)
for name, row in zip(("left", "right", "rear"), matrix.round(4) + 0.0):
    print(f"{name:6s} forward {row[0]:7.4f}   left {row[1]:7.4f}   turn {row[2]:7.4f} m")

# %% [markdown]
# Read the rear row. On a left turn the rear wheel goes to the **right**, so it counts down.
# In front of the centre it would count up.

# %% [markdown]
# ## 6. From wheels to the body
#
# Now backwards. $A \Delta = d$ are three equations for three unknowns. With more wheels there are
# more equations than unknowns, and they never quite agree. Then take the $\Delta$ that comes closest:
# **least squares**. `np.linalg.pinv(A)` is the matrix that does it; for three wheels it is the inverse.
#
# A gyroscope knows the turn better than wheels do. Then $\Delta_\theta$ is known, and only two unknowns
# are left. Take off what the turn rolls, and solve for the rest:
#
# $$A_{xy} \begin{pmatrix} \Delta_x \\ \Delta_y \end{pmatrix} = d - A_\theta\, \Delta_\theta$$
#
# $A_{xy}$ are the first two columns of $A$, $A_\theta$ is the third.

# %% [markdown]
# ### Exercise: motion of the body (3 points)
#
# `yaw` holds headings, one more than there are samples. Between 179° and −179° lie 2°.


# %% exercise="odometry.body_deltas"
def body_deltas(wheels, travel, yaw=None):
    """Motion of the body in each sample.

    wheels : odometry.TrackingWheels, three wheels or more
    travel : (n, k) array [m], what each wheel rolled
    yaw : (n + 1,) array [rad, map] or None; with it the turn is the gyroscope's, not the wheels'
    returns : (n, 3) array, forward, left, turn [m, m, rad; base at the start of each sample]
    """
    ### BEGIN SOLUTION
    matrix = wheel_matrix(wheels.positions, wheels.directions)
    if yaw is None:
        return travel @ np.linalg.pinv(matrix).T
    turn = (np.diff(yaw) + np.pi) % (2 * np.pi) - np.pi
    rest = travel - turn[:, None] * matrix[:, 2]
    return np.column_stack([rest @ np.linalg.pinv(matrix[:, :2]).T, turn])
    ### END SOLUTION


# %% check="odometry.body_deltas"
body_deltas = check("odometry.body_deltas")

# %% [markdown]
# ### Another robot, the same function
#
# A **differential drive** has two wheels side by side. They cannot feel sideways motion, but their
# own axle forbids it. So it has a third wheel, across, that never rolls: its travel is 0.

# %%
base = 0.32  # m between the two wheels
differential = odometry.TrackingWheels(
    [[0, base / 2], [0, -base / 2], [0, 0]], [0, 0, np.pi / 2], radius=0.05, ticks_per_turn=3200
)
left, right = 0.10, 0.13
forward, aside, turn = body_deltas(differential, np.array([[left, right, 0.0]]))[0] + 0.0
print(f"forward {forward:.4f} m, the mean of both: {(left + right) / 2:.4f} m")
print(f"turn {turn:.5f} rad, their difference over the base: {(right - left) / base:.5f} rad")

# %% [markdown]
# ## 7. From motion to poses
#
# Within one sample the robot drives and turns at the same time: it follows an **arc**.
# Its end lies on the **chord**, the straight line from start to end.
#
# - The chord points along the heading **halfway**, $\theta + h$, where $h$ is half the turn.
# - It is shorter than the arc, by the factor $\sin(h) / h$.
#
# $$\begin{pmatrix} x \\ y \end{pmatrix} \leftarrow \begin{pmatrix} x \\ y \end{pmatrix} + \frac{\sin h}{h}
# \begin{pmatrix} \cos(\theta + h) & -\sin(\theta + h) \\ \sin(\theta + h) & \cos(\theta + h) \end{pmatrix}
# \begin{pmatrix} \Delta_x \\ \Delta_y \end{pmatrix}, \qquad \theta \leftarrow \theta + 2h$$
#
# Nothing in it is approximate, as long as the robot's speed is constant within the sample.

# %%
quarter = np.pi / 2
arc = odometry.integrate(np.tile([quarter, 0, quarter], (50, 1)) / 50)
ends = {
    "wrong: heading at the start": (quarter, 0.0),
    "halfway heading, arc's length": quarter * np.array([1, 1]) / np.sqrt(2),
    "reference: the chord": (1.0, 1.0),
}
fits = {name: np.array([(0.0, 0.0), end]) for name, end in ends.items()}
missed = [np.hypot(*np.subtract(end, (1, 1))) for end in ends.values()]
show(
    plots.plot_paths({"truth": arc} | fits),
    "A quarter circle of radius 1 m in one step. The heading at the start (Euler) misses the end by "
    f"{missed[0]:.2f} m, the heading halfway with the arc's length by {missed[1]:.2f} m, the chord by "
    f"{missed[2]:.2f} m.",
)

# %% [markdown]
# ### Exercise: poses (3 points)
#
# Leave the heading unwrapped. Mind the step without a turn: $\sin(0)/0$ is 1, but not in Python.


# %% exercise="odometry.integrate"
def integrate(deltas, start=(0.0, 0.0, 0.0)):
    """Poses along exact arcs.

    deltas : (n, 3) array, forward, left, turn [m, m, rad; base at the start of each step]
    start : (3,) array [m, m, rad; map]
    returns : (n + 1, 3) array [m, m, rad; map], the start, then the pose after each step
    """
    ### BEGIN SOLUTION
    x, y, theta = start
    poses = [(x, y, theta)]
    for forward, left, turn in deltas:
        chord = np.sinc(turn / 2 / np.pi)  # sin(h) / h, and 1 at h = 0
        c, s = chord * np.cos(theta + turn / 2), chord * np.sin(theta + turn / 2)
        x, y = x + c * forward - s * left, y + s * forward + c * left
        theta = theta + turn
        poses.append((x, y, theta))
    return np.array(poses)
    ### END SOLUTION


# %% check="odometry.integrate"
integrate = check("odometry.integrate")

# %% [markdown]
# ## 8. How fast?
#
# A speed controller wants to know how fast the robot is, **with the sign**: forwards or backwards,
# left or right. One count in 10 ms is 6 mm/s, too coarse. The robot of the source looks
# every 50 ms.
#
# It is `integrate` backwards. Take two poses, see the step from the robot, stretch the chord to
# its arc, divide by the time.

# %% [markdown]
# ### Exercise: velocity (2 points)
#
# Headings may be wrapped. The turn between two poses is the shorter one.


# %% exercise="odometry.body_velocity"
def body_velocity(poses, dt):
    """Velocity between poses, in the robot's own axes.

    poses : (n + 1, 3) array [m, m, rad; map], one every dt
    dt : float [s]
    returns : (n, 3) array, forward, left, turn [m/s, m/s, rad/s; base]
    """
    ### BEGIN SOLUTION
    step = np.diff(poses, axis=0)
    turn = (step[:, 2] + np.pi) % (2 * np.pi) - np.pi
    look = poses[:-1, 2] + turn / 2
    c, s = np.cos(look), np.sin(look)
    forward = c * step[:, 0] + s * step[:, 1]
    left = c * step[:, 1] - s * step[:, 0]
    chord = np.sinc(turn / 2 / np.pi)
    return np.column_stack([forward / chord, left / chord, turn]) / dt
    ### END SOLUTION


# %% check="odometry.body_velocity"
body_velocity = check("odometry.body_velocity")

# %% [markdown]
# ## 9. Play: what a wrong size does
#
# A perfect robot drives the square once. You believe something wrong about its wheels:
# the left one is larger, left and right stand further apart, the rear one stands further back.
#
# **Task.** Which of the three bends straight lines? Which makes the corners wrong? Which shows only
# while the robot turns, and how large must it be before you see it?


# %%
lap = np.array([(2.0, 0.0, 0.0), (0.0, 0.0, np.pi / 2)] * 4)
lap = np.repeat(lap / 50, 50, axis=0)


# %%
def draw_square(left_radius, track, rear):
    """The square as it seems with wrong sizes: per cent, mm, mm."""
    shift = np.array([[0, track / 2], [0, -track / 2], [-rear, 0]]) / 1000
    radius = DEAD_WHEELS.radius * [1 + left_radius / 100, 1, 1]
    believed = odometry.TrackingWheels(
        DEAD_WHEELS.positions + shift, DEAD_WHEELS.directions, radius, 3200
    )
    rolled = lap @ DEAD_WHEELS.matrix.T / DEAD_WHEELS.metres_per_tick
    seen, truth = path(believed, rolled), odometry.integrate(lap)
    off = seen[-1] - truth[-1]
    text = f"left radius {left_radius:+g} %, track {track:+g} mm, rear {rear:+g} mm"
    end = f"{1000 * np.hypot(*off[:2]):.0f} mm off and turned by {np.degrees(off[2]):+.1f}°"
    fig = plots.plot_paths({"truth": truth, "wrong sizes": seen})
    return fig, f"Believed {text}: the square ends {end}."


explore(draw_square, left_radius=(-1.5, 1.5, 0.1, 0.6), track=(-10, 10, 1, 0), rear=(-10, 10, 1, 0))

# %% [markdown]
# ## 10. Calibration
#
# First: how bad is it with the sizes in the drawing? All your parts in a row:


# %%
def reckon(wheels, log):
    """Poses of a log, on the functions of this notebook."""
    travel = wheel_travel(wheels, tick_changes(log.counters, worlds.BITS))
    return integrate(body_deltas(wheels, travel))


# %% [markdown]
# ### Your number: the end of the square (1 point)
#
# With the drawing's sizes, `DEAD_WHEELS`: how many millimetres is the end of *your* square,
# `world.square`, from where the robot really stood, `world.square.poses[-1]`?

# %% answer="odometry.own_square"
answer(
    "odometry.own_square",
    ### BEGIN SOLUTION
    float(1000 * np.hypot(*(reckon(DEAD_WHEELS, world.square)[-1] - world.square.poses[-1])[:2])),
    ### END SOLUTION
)

# %% [markdown]
# ### A run and a spin
#
# Two short drives find the sizes. No instrument is needed but a tape.
#
# **The run.** Push the robot straight, without a turn, by a measured $(\Delta_x, \Delta_y)$. Slanting, so
# that all three wheels roll. Wheel $i$ rolls a known way, so its counts give its radius:
#
# $$2 \pi r_i \frac{\text{counts}_i}{N} = \cos a_i\, \Delta_x + \sin a_i\, \Delta_y$$
#
# **The spin.** Turn the robot on the spot by a known angle, ten full turns say. Each wheel rolls its
# lever arm times the angle:
#
# $$x_i \sin a_i - y_i \cos a_i = \frac{d_i}{\text{angle}}$$
#
# Where a wheel stands *along* its own direction never shows. So move it square to that, by
# $(\sin a, -\cos a)$ times what is missing of its lever arm.

# %% [markdown]
# ### Exercise: calibrate the wheels (3 points)
#
# Return `odometry.TrackingWheels(positions, directions, radius, ticks_per_turn)`. Use the new radii
# for the spin.


# %% exercise="odometry.calibrate_wheels"
def calibrate_wheels(wheels, run_ticks, run, spin_ticks, angle):
    """Radii and positions from a straight run and a spin on the spot.

    wheels : odometry.TrackingWheels, sizes in the drawing
    run_ticks, spin_ticks : (k,) arrays, counts over the whole run and the whole spin
    run : (2,) array [m, base], forward and left
    angle : float [rad], left is positive
    returns : odometry.TrackingWheels, the wheels as they are
    """
    ### BEGIN SOLUTION
    a = wheels.directions
    along = np.column_stack([np.cos(a), np.sin(a)])
    across = np.column_stack([np.sin(a), -np.cos(a)])
    radius = along @ run * wheels.ticks_per_turn / (2 * np.pi * run_ticks)
    lever = 2 * np.pi * radius * spin_ticks / wheels.ticks_per_turn / angle
    missing = lever - (across * wheels.positions).sum(axis=1)
    positions = wheels.positions + missing[:, None] * across
    return odometry.TrackingWheels(positions, a, radius, wheels.ticks_per_turn)
    ### END SOLUTION


# %% check="odometry.calibrate_wheels"
calibrate_wheels = check("odometry.calibrate_wheels")

# %%
run_ticks = tick_changes(world.run.counters, worlds.BITS).sum(axis=0)
spin_ticks = tick_changes(world.spin.counters, worlds.BITS).sum(axis=0)
mine = calibrate_wheels(DEAD_WHEELS, run_ticks, np.array(worlds.RUN), spin_ticks, worlds.SPIN)
change = 100 * (mine.radius / DEAD_WHEELS.radius - 1)
for name, percent in zip(("left", "right", "rear"), change):
    print(f"{name:6s} radius {percent:+.2f} % off the drawing")
tracks = [1000 * (w.positions[0, 1] - w.positions[1, 1]) for w in (DEAD_WHEELS, mine)]
print(f"track {tracks[1]:.1f} mm instead of {tracks[0]:.1f} mm")

# %% [markdown]
# ### Your number: the rear wheel (1 point)
#
# By how many millimetres does *your* rear wheel stand further behind the centre than the drawing says?
# The drawing says 274.5 mm. Negative means nearer to the centre.

# %% answer="odometry.own_offset"
answer(
    "odometry.own_offset",
    ### BEGIN SOLUTION
    float(1000 * (DEAD_WHEELS.positions[2, 0] - mine.positions[2, 0])),
    ### END SOLUTION
)

# %% [markdown]
# ### The error grows with the way
#
# Nothing in odometry ever looks at the world. Each error stays in the pose, and the next one joins it.
# The heading's error is the worst: it turns everything that follows.

# %%
truth, way = world.square.poses, world.square.distance
errors = {
    "wrong sizes": np.hypot(*(reckon(DEAD_WHEELS, world.square) - truth)[:, :2].T),
    "calibrated": np.hypot(*(reckon(mine, world.square) - truth)[:, :2].T),
}
fig, ax = figure(7.0, 3.2)
for (name, error), colour in zip(errors.items(), (plots.WARN, plots.MINE)):
    ax.plot(way, 1000 * error, color=colour, label=name)
ax.set(xlabel="way driven [m]", ylabel="position error [mm]")
ax.legend()
last = {name: 1000 * error[-1] for name, error in errors.items()}
show(
    fig,
    f"Position error over {way[-1]:.0f} m: it grows to {last['wrong sizes']:.0f} mm with the drawing's "
    f"sizes, to {last['calibrated']:.0f} mm with calibrated ones.",
)

# %% [markdown]
# A calibration is not perfect either. Nobody sees that the robot turned by 0.1° in its run. Left and
# right then come out a few hundredths of a per cent too different. That is the error that is left.
#
# Where somebody films the robot from above, the whole path is known, not only its end.
# `odometry.self_calibrate` then finds the sizes that follow it best.

# %% [markdown]
# ## 11. Break it
#
# What goes wrong on real robots, one failure at a time, on your square with calibrated wheels.


# %%
def farthest(wheels, counts):
    """Largest error on the way, and turn at the end [m, deg], on the course's parts."""
    off = path(wheels, counts) - true_square
    return np.hypot(*off[:, :2].T).max(), np.degrees(off[-1, 2])


failures = {"good log": farthest(calibrated, square)}
lost, lifted, unmended = square.copy(), square.copy(), np.diff(world.square.counters, axis=0)

# %% [markdown]
# **Slip.** A wheel hops over a cable and hangs in the air for 0.2 s. **A lost encoder.** A plug is
# loose for one second. Either way left and right no longer agree, and the robot seems to turn.

# %%
lifted[650:670, 0] = 0
lost[1650:1750, 1] = 0
failures["left wheel in the air for 0.2 s"] = farthest(calibrated, lifted)
failures["right encoder lost for 1 s"] = farthest(calibrated, lost)

# %% [markdown]
# **Swapped plugs.** Left and right change places: the robot turns the other way.
# **A counter that runs backwards** is a rear wheel on the other side of the centre.
#
# **800 instead of 3200.** Everything is four times as large, turns too.
# **Counters not mended.** One jump at the end of the range is 3.8 m of way.

# %%
failures["left and right swapped"] = farthest(calibrated, square[:, [1, 0, 2]])
failures["rear counter backwards"] = farthest(calibrated, square * [1, 1, -1])
failures["800 instead of 3200"] = farthest(calibrated, 4 * square)
failures["counters not mended"] = farthest(calibrated, unmended)
for name, (far, turned) in failures.items():
    print(f"{name:32s} up to {far:7.3f} m off, at the end turned by {turned:8.1f}°")

# %%
names = list(failures)[::-1]
far = [failures[name][0] for name in names]
fig, ax = figure(7.0, 3.4)
ax.barh(names, far, color=[plots.REFERENCE if f < 0.05 else plots.WARN for f in far])
for row, name in enumerate(names):
    ax.text(far[row], row, f" {far[row]:.2f} m", va="center")
ax.set(xscale="log", xlabel="largest error on the way [m]", xlim=(0.005, 6 * max(far)))
ax.grid(axis="y", visible=False)
worst = names[int(np.argmax(far))]
show(fig, f"Largest errors, from {min(far):.3f} m to {max(far):.1f} m ({worst}), on a log scale.")

# %% [markdown]
# A rear counter that runs backwards moves the path by up to a metre at each corner. After four corners it is
# back: the end of a closed square does not show it. Test with a spin.

# %% [markdown]
# ## 12. Check the source
#
# **The sign of the rear wheel.** The thesis of a real robot prints
# $\Delta y = \Delta C - (\Delta R - \Delta L) \cdot \text{offset} / \text{track}$. That is right for a wheel in front of the
# centre. This one is behind it. A turn on the spot then reads as sideways travel of twice the offset
# times the angle.


# %%
def printed_deltas(travel, track=0.5377, offset=0.2745):
    """The thesis' formula for left, right and rear wheel."""
    left, right, rear = travel.T
    turn = (right - left) / track
    return np.column_stack([(left + right) / 2, rear - turn * offset, turn])


half_turn = np.tile([0.0, 0.0, np.pi / 100], (100, 1)) @ DEAD_WHEELS.matrix.T
printed = odometry.integrate(printed_deltas(half_turn))
stays = odometry.integrate(odometry.body_deltas(DEAD_WHEELS, half_turn))

# %%
show(
    plots.plot_paths(
        {"wrong: as printed": printed}, markers={"stands here": stays[-1, :2]}, headings=6
    ),
    "Half a turn on the spot. With the printed sign the robot seems to drive half a circle and to end "
    f"{np.hypot(*printed[-1, :2]):.3f} m away; with the wheel where it is, "
    f"behind the centre, {np.hypot(*stays[-1, :2]):.3f} m.",
)

# %% [markdown]
# **Which heading?** The thesis works out the heading halfway, and then does not use it. Its listing
# turns each step by the IMU's angle **after** the sample, minus 90°. The text says nothing of the 90°.
# Here the robot drives half a circle of radius 1 m, at 1 m/s, a sample every 50 ms.

# %%
steps = np.tile([0.05, 0.0, 0.05], (63, 1))
half_circle = odometry.integrate(steps)


def by_heading(shift):
    """The path when each step goes along the heading after it, plus a shift."""
    look = half_circle[1:, 2] + shift
    x, y = np.cumsum(steps[:, 0] * np.cos(look)), np.cumsum(steps[:, 0] * np.sin(look))
    return np.vstack([(0.0, 0.0), np.column_stack([x, y])])


listing, text = by_heading(-np.pi / 2), by_heading(0.0)
late = 1000 * np.hypot(*(text[-1] - half_circle[-1, :2]))
show(
    plots.plot_paths(
        {"truth": half_circle, "wrong: minus 90°": listing, "heading after the step": text}
    ),
    f"Half a circle. The heading after the step turns the whole path by half a step, {late:.0f} mm at the "
    "end; minus 90° turns it by a right angle.",
)

# %% [markdown]
# **Speed without a sign.** The thesis takes absolute differences, and does not wrap the heading.
# The robot drives forward, stops, and drives back, while its heading passes 180°.

# %%
moment = np.arange(0.0, 4.0, 0.05)
twist = np.column_stack([np.sin(np.pi * moment / 2), 0 * moment, np.full_like(moment, 0.2)])
drive = odometry.integrate(twist * 0.05, (0, 0, np.radians(165)))
drive[:, 2] = geometry.wrap_angle(drive[:, 2])
change = np.abs(np.diff(drive, axis=0)) / 0.05
thesis = np.column_stack([np.hypot(change[:, 0], change[:, 1]), change[:, 2]])
ours = odometry.body_velocity(drive, 0.05)[:, [0, 2]]

# %%
fig, panels = figure(7.5, 3.0, columns=2)
for ax, column, name in zip(panels, (0, 1), ("forward [m/s]", "turn [rad/s]")):
    ax.plot(moment, thesis[:, column], color=plots.WARN, label="as printed")
    ax.plot(moment, ours[:, column], color=plots.REFERENCE, label="signed, wrapped")
    ax.set(xlabel="time [s]", title=name)
panels[0].legend()
show(
    fig,
    f"Forward speed from {ours[:, 0].min():.2f} to {ours[:, 0].max():.2f} m/s; as printed it never falls "
    f"below 0. The turn rate is {ours[0, 1]:.1f} rad/s; as printed it jumps to "
    f"{thesis[:, 1].max():.0f} rad/s where the heading passes 180°.",
)

# %% [markdown]
# **The total distance.** A paper on path tracking prints $x = d \sin\theta$, $y = d \cos\theta$, with the
# heading clockwise from the y axis and $d$ the **total** distance. That holds on the first straight line
# only. On its own test path, (0, 0) (0, 150) (150, 150) (151, 0) cm, each corner swings the whole way round.

# %%
corners = np.array([(0, 0), (0, 1.5), (1.5, 1.5), (1.51, 0)])
legs = np.diff(corners, axis=0)
heading = np.repeat(np.arctan2(legs[:, 0], legs[:, 1]), 50)  # clockwise from y, as in the paper
part = np.repeat(np.hypot(*legs.T) / 50, 50)
total = np.cumsum(part)
printed = np.column_stack([total * np.sin(heading), total * np.cos(heading)])
summed = np.column_stack([np.cumsum(part * np.sin(heading)), np.cumsum(part * np.cos(heading))])
printed_end, summed_end = (100 * np.hypot(*(p[-1] - corners[-1])) for p in (printed, summed))
show(
    plots.plot_paths({"truth": corners, "wrong: as printed": printed, "reference: summed": summed}),
    f"The paper's first test path. With the total distance it ends {printed_end:.0f} cm from the last "
    f"corner, summed step by step {summed_end:.1f} cm.",
)

# %% [markdown]
# **What holds.** For three omni wheels at the angles $\delta$, the thesis prints the inverse of the wheel
# matrix in closed form (equation 6). It is right, and it is ours.

# %%
delta = np.radians([60, 180, 300])
radius, lever = np.array([0.05, 0.051, 0.049]), np.array([0.2, 0.21, 0.19])
sine, cosine = np.sin(delta), np.cos(delta)
columns, below = [], 0.0
for k, (i, j, sign) in enumerate([(1, 2, 1), (0, 2, -1), (0, 1, 1)]):  # one wheel k, the two others
    between = np.sin(delta[i] - delta[j])
    top = lever[i] * cosine[j] - lever[j] * cosine[i], lever[i] * sine[j] - lever[j] * sine[i]
    columns.append(sign * radius[k] * np.array([*top, between]))
    below += sign * lever[k] * between
places = lever[:, None] * np.column_stack([cosine, sine])
ours = np.linalg.inv(wheel_matrix(places, delta + np.pi / 2) / radius[:, None])
difference = np.abs(np.column_stack(columns) / below - ours).max()
print(f"equation 6 and the inverse of our matrix differ by less than 1e-12: {difference < 1e-12}")

# %% [markdown]
# | printed | what happens | instead |
# |---|---|---|
# | rear wheel's term with minus | half a turn reads as half a circle | sign of $x_i$ kept, $x \sin a - y \cos a$ |
# | half-step heading not used | the path is turned by half a step | $\theta + h$ |
# | IMU angle minus 90° in the listing only | the path is turned by 90° | one convention: 0 is the map's x |
# | absolute differences, not wrapped | no backwards; a jump at 180° | signed, wrapped |
# | equation 4: heading at the start | Euler: too far outside in curves | arcs |
# | total distance times sin, cos | corners swing the whole way | add up steps |
# | equation 6 | holds | – |

# %% [markdown]
# ## 13. Link-up: your parts in the robot
#
# Now the robot has mass, its wheels grip and slip, and it drives about Area 1 in the simulator.
# Three rungs:
#
# - **ideal**: built as drawn, perfect IMU;
# - **noisy**: your robot and your IMU; now and then a wheel hops over a seam in the floor;
# - **degraded**: one encoder is silent for 2 s, wheels hang in the air for up to half a second.
#
# `dead_reckoning` puts the parts in a row. The heading comes from the gyroscope, and the wheels teach
# it its bias whenever the robot stands still.

# %%
simulator.warm_up()
my_parts, course = robot_parts("mixed"), robot_parts("reference")


def sizes(parts):
    """Your robot's wheels, calibrated on some parts."""
    run, spin = (
        parts.tick_changes(log.counters, worlds.BITS).sum(axis=0) for log in (world.run, world.spin)
    )
    return parts.calibrate_wheels(DEAD_WHEELS, run, np.array(worlds.RUN), spin, worlds.SPIN)


# %%
def run(parts, drive, heading="fused", at_rest=True):
    """Poses of a drive on some parts, and their errors [m, deg]."""
    wheels = DEAD_WHEELS if drive.wheels is DEAD_WHEELS else sizes(parts)
    known = {"start": drive.poses[0], "heading": heading}
    if at_rest:
        known["bias"] = parts.calibrate_gyro(drive.still).bias[2]
        known["taught"] = 0.01 * len(drive.still)  # s
    poses = dead_reckoning(parts, drive.observations, wheels, **known)
    off = poses - drive.poses
    return poses, np.hypot(*off[:, :2].T), np.degrees(off[:, 2])


# %%
drives = {kind: worlds.simulated_drive(student, kind) for kind in worlds.DRIVES}
print(f"Parts: {my_parts.label}")
for kind, drive in drives.items():
    ends = [1000 * run(parts, drive)[1][-1] for parts in (course, my_parts)]
    way = np.hypot(*np.diff(drive.poses[:, :2], axis=0).T).sum()
    who = f"{ends[0]:4.0f} mm off on the course's parts, {ends[1]:4.0f} mm on yours"
    print(f"{kind:9s} after {way:.0f} m: {who}")

# %%
drive = drives["noisy"]
half = slice(0, len(drive.poses) // 2, 2)
found, whose = run(my_parts, drive), "mine" if my_parts.mine else "reference"
show(
    animate(
        drive.time[half],
        {"truth": drive.poses[half], whose: found[0][half]},
        angles=np.array([one.module_angles for one in drive.observations[half]]),
        window=(0, 6, 0, 4),
        frames=60,
    ),
    f"The first {drive.time[half][-1]:.0f} s of the noisy drive in Area 1, truth and odometry ({my_parts.label}): never "
    f"more than {1000 * found[1][half].max():.0f} mm apart.",
)

# %%
rough = drives["degraded"]
by_course, by_mine = run(course, rough), run(my_parts, rough)
early = slice(0, len(rough.poses) // 2)
paths = {"truth": rough.poses[early], "reference": by_course[0][early]}
paths |= {"mine": by_mine[0][early]} if my_parts.mine else {}
show(
    plots.draw_field(paths, window=(0, 6, 0, 4)),
    f"The first half of the degraded drive. The heading holds within {np.abs(by_course[2]).max():.2f}°, but wheels that do "
    f"not count leave the position {by_course[1][early][-1]:.2f} m off on the course's parts, "
    f"{by_mine[1][early][-1]:.2f} m on yours ({my_parts.label}).",
)

# %% [markdown]
# The gyroscope saves the heading. It cannot tell how far the robot went while a wheel did not count.
# The challenge can.

# %% [markdown]
# ## 14. Three minutes: who should say the heading?
#
# One match, 180 s, with bumps; the simulator takes some seconds for it. The same wheels, four ways
# to a heading:
#
# - **wheels**: from the difference of left and right;
# - **gyro, raw**: from the gyroscope as it is;
# - **gyro, calibrated**: its bias taken off, measured at rest before the start;
# - **fused**: from the raw gyroscope, whose bias the wheels teach at each stop.

# %%
match = worlds.simulated_drive(student, "noisy", 180.0)
by = {
    "wheels": run(course, match, "wheels"),
    "gyro, raw": run(course, match, "gyro", at_rest=False),
    "gyro, calibrated": run(course, match, "gyro"),
    "fused": run(course, match, "fused", at_rest=False),
}
rms = {name: np.sqrt(np.mean(np.square(found[2]))) for name, found in by.items()}
print("                  heading, RMS   position at the end    at worst")
for name, (_, far, _) in by.items():
    print(f"{name:18s} {rms[name]:8.2f}° {1000 * far[-1]:15.0f} mm {1000 * far.max():11.0f} mm")

# %%
good = {name: found[0] for name, found in by.items() if name != "gyro, raw"}
show(
    plots.plot_pose_errors(match.time, good, match.poses),
    "Errors over a match of 180 s. RMS of the heading: "
    + ", ".join(f"{name} {rms[name]:.2f}°" for name in good)
    + f". The position is off by {1000 * by['fused'][1][-1]:.0f} mm at the end with the fused heading.",
)

# %% [markdown]
# Slip looks like a turn to the wheels only, bias to the gyroscope only. Wheels know when the robot
# stands: whatever the gyroscope says then is bias. Calibrated and fused are alike here. But fused needed
# no log at rest, and it follows a bias that changes while the gyroscope warms up.
#
# The position drifts with any heading. Only a look at the world stops that: in later chapters the LiDAR
# looks at the walls.

# %% [markdown]
# ## 15. Challenge: a rough drive (4 points)
#
# One encoder, left or right, is silent for some seconds. Wheels hang in the air. The gyroscope has a bias
# nobody measured, and gaps. Never two of these at the same moment. Each drive begins with one second at rest.
#
# Write your own dead reckoning. It is judged by the largest distance from the truth in the worst of three
# drives: up to 0.1 m earns all points, up to 0.5 m half of them. Fused heading alone is off by more than 1 m.
#
# Ideas: two wheels and a gyroscope know the turn twice. When they disagree, who is wrong?
# A dead wheel has no motor. Can it roll too much? What do the wheels say while the gyroscope is silent?


# %% exercise="odometry.rough_drive_poses"
def rough_drive_poses(wheels, ticks, gyro, dt):
    """Poses of a rough drive, from (0, 0, 0).

    wheels : odometry.TrackingWheels, left, right and rear; calibrated
    ticks : (n, 3) array, counts of each sample
    gyro : (n,) array [rad/s], rate about z; NaN where nothing came
    dt : float [s]
    returns : (n + 1, 3) array [m, m, rad; map]
    """
    ### BEGIN SOLUTION
    travel = wheel_travel(wheels, ticks)
    matrix = wheel_matrix(wheels.positions, wheels.directions)
    turn = (gyro - np.nanmean(gyro[:80])) * dt
    turn = np.where(np.isnan(turn), body_deltas(wheels, travel)[:, 2], turn)
    left, right, rear = (travel - turn[:, None] * matrix[:, 2]).T
    larger = np.where(np.abs(left) > np.abs(right), left, right)
    forward = np.where(np.abs(left - right) > 3e-4, larger, (left + right) / 2)
    return integrate(np.column_stack([forward, rear, turn]))
    ### END SOLUTION


# %% check="odometry.rough_drive_poses"
rough_drive_poses = check("odometry.rough_drive_poses")

# %% [markdown]
# ## 16. Summary
#
# - A wheel feels motion along its own direction. One row of a matrix says how much, lever arm included.
# - The inverse of that matrix, or least squares, gives the motion of the body.
# - Steps are arcs: along the heading halfway, a little shorter than the arc.
# - Odometry drifts with the way driven. Calibration makes the drift small, nothing in the robot makes it 0.
# - Heading errors are the worst. Take the heading from gyroscope and wheels together.
#
# **Ask yourself.** Why must the run be slanting? What would a rear wheel exactly at the centre feel, and
# what would be lost? Which wrong size does a closed square hide? Why is $h$ half the turn, and not
# the turn? When is the wheels' heading better than the gyroscope's?
#
# ## Glossary
#
# | English | Bahasa Indonesia |
# |---|---|
# | odometry, dead reckoning | odometri |
# | dead wheel | roda pengukur (tanpa penggerak) |
# | count, tick | hitungan pulsa |
# | wrap around | kembali ke nol (luapan pencacah) |
# | track width | jarak antar roda kiri dan kanan |
# | lever arm | lengan momen |
# | heading | arah hadap |
# | chord, arc | tali busur, busur |
# | slip | selip |
# | least squares | kuadrat terkecil |
#
# ## Reading
#
# K. Lynch, F. Park: *Modern Robotics*, Cambridge 2017, section 13.4: odometry by pseudo-inverse.
#
# J. Borenstein, L. Feng: *Measurement and correction of systematic odometry errors in mobile robots*, IEEE
# Transactions on Robotics and Automation 12(6), 1996. Why a square must be driven both ways round.
#
# Sources: thesis on the autonomous localisation and navigation of a swerve-drive robot, Universitas Negeri
# Yogyakarta, 2024, part "Sistem Three-Wheel Odometry"; B. S. Marta, F. Ardilla, A. R. A. Besari: *Path Tracking
# pada Mobile Robot dengan Umpan Balik Odometry*, Politeknik Elektronika Negeri Surabaya.
#
# ## Where you are

# %%
status()

# %% [markdown]
# # 03 · Swerve: four wheels, one motion
#
# You turn one command for the body into speeds and angles of four steered wheels, and four
# wheels back into one motion. At the end your robot follows a moving target.
#
# | | |
# |---|---|
# | Time | 3 to 4 hours |
# | You need | chapter 00, vectors, least squares from chapter 02 |
# | Points | 22: seven functions, two numbers, one challenge |
# | Your robot gains | `module_targets`, `field_to_robot`, `shortest_turn`, `limit_speeds`, `body_twist`, `discretize`, `pose_feedback` |

# %%
from dataclasses import replace

import numpy as np

from robocon_course import geometry, swerve, worlds
from robocon_course.autopilot import module_command
from robocon_course.exercises import answer, begin, check, hint, robot_parts, status
from robocon_course.robot import MODULES, Command
from robocon_course.simulator import RobotModel, Simulator, warm_up
from robocon_course.view import RobotPicture, animate, drive, explore, figure, pictures, plots, show

student = begin("swerve", student=None)  # None: the number you gave in chapter 00
world = worlds.swerve_world(student)

# %% [markdown]
# ## 1. Where this part sits

# %%
show(
    pictures.draw_system(here="03"),
    "The swerve modules are the last box before the Command: a body twist goes in, four speeds and "
    "four angles come out.",
)

# %% [markdown]
# ## 2. See it work
#
# A target runs along a figure eight. The robot follows it and turns once around itself meanwhile:
# a swerve drive may look anywhere. The course's parts drive the simulated robot.
#
# A **twist** is a velocity and a turn rate together: $(v_x, v_y, \omega)$.


# %%
def eight(t, period=8.0):
    """A target on a figure eight in Area 1 that turns around itself: pose and twist at times t."""
    pose, twist = swerve.figure_eight(t, period=period)
    pose, twist = pose + np.array([1.9, 1.1, 0.0]), twist.copy()
    pose[..., 2], twist[..., 2] = 2 * np.pi * t / period, 2 * np.pi / period
    return swerve.Target(pose, twist)


# %% [markdown]
# One tick of the robot: where is the target, how fast should I move, what do the modules do? You
# build the parts of this loop one by one. `truth` plays a camera over the field; chapter 02's
# odometry could take its place.


# %%
def run(parts, *, model=None, spoil=None, dt=0.02, delay=0):
    """Follow the eight in the simulator: time, poses, targets, angles, speeds, slip."""
    robot, rows, seen = Simulator(model, start=eight(0.0).pose), [], []
    for t in np.arange(0.0, 8.0, dt):
        goal, now = eight(t), robot.read()
        seen.append(robot.truth.pose)
        pose = seen[max(len(seen) - 1 - delay, 0)]
        velocity = parts.pose_feedback(pose, goal.pose, 3.0, goal.twist)
        order = module_command(parts, velocity, pose[2], now.module_angles, dt=dt)
        robot.apply(Command(*spoil(order.speeds, order.angles)) if spoil else order)
        speeds, slip = now.module_speeds, robot.truth.slip
        rows.append((t, seen[-1], goal.pose, now.module_angles, speeds, slip))
        robot.step(dt)
    return [np.array(column) for column in zip(*rows)]


warm_up()


# %%
def distance(log):
    """Mean distance to the target after the first second [mm]."""
    time, poses, targets = log[:3]
    return 1000 * np.hypot(*(poses - targets)[time > 1.0, :2].T).mean()


course = robot_parts("reference")
log = run(course)
show(
    animate(log[0], {"reference": log[1]}, angles=log[3], speeds=log[4], frames=36),
    f"The robot follows a figure eight for 8 s and turns around itself once, {distance(log):.0f} mm "
    "from its target on average.",
)

# %% [markdown]
# ## 3. One velocity for each place
#
# A body that drives and turns has a different velocity at each of its places.
# What the turn adds at a place $r = (x, y)$ points across $r$ and grows with its length:
#
# $$v(r) = v + \omega \times r, \qquad a = v_x - \omega\, y, \qquad b = v_y + \omega\, x$$
#
# | symbol | meaning | unit, frame |
# |---|---|---|
# | $v_x, v_y$ | velocity of the body's middle: forward, left | m/s, base |
# | $\omega$ | turn rate, left positive | rad/s |
# | $\xi$ `twist` | $(v_x, v_y, \omega)$ | base or map, as said |
# | $x_i, y_i$ `drive` | place of module $i$ | m, base |
# | $a_i, b_i$ | velocity of module $i$: forward, left | m/s, base |
# | $u_i$ `speeds`, $\alpha_i$ `angles` | speed and direction of wheel $i$ | m/s, rad, base |
# | $\theta$ `theta` | heading of the robot | rad, map |
# | $\lambda$ `gain` | how fast an error fades | 1/s |
# | $\Delta t$ `dt` | how long a command holds | s |
#
# The modules are numbered around: front left, rear left, rear right, front right.


# %%
WHEELS = ("front left", "rear left", "rear right", "front right")


def draw_arrows(ax, targets, title):
    """The robot from above, forward to the right, and the velocity of each module; in words."""
    speeds, angles = targets
    corners = 0.325 * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    ax.fill(*corners.T, color="0.92")
    ax.fill([0.2, 0.3, 0.2], [0.06, 0.0, -0.06], color="0.6")
    ax.plot(*MODULES.T, "o", color="0.3", markersize=4)
    arrows = speeds * np.cos(angles), speeds * np.sin(angles)
    style = {"angles": "xy", "scale_units": "xy", "scale": 3.0, "width": 0.014}
    ax.quiver(*MODULES.T, *arrows, color=plots.MINE, zorder=3, **style)
    ax.set(aspect="equal", xlim=(-0.62, 0.8), ylim=(-0.6, 0.6), title=title)
    ax.set_axis_off()
    return "; ".join(f"{u:.2f} m/s at {np.degrees(a):.0f}°" for u, a in zip(speeds, angles))


# %%
fig, panels = figure(8.2, 2.7, columns=3)
ahead, left = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 2.0])
motions = {"1 m/s ahead": ahead, "2 rad/s to the left": left, "both: the sum": ahead + left}
for ax, (title, twist) in zip(panels, motions.items()):
    words = draw_arrows(ax, swerve.module_targets(MODULES, twist, np.zeros(4)), title)
show(fig, f"Velocities of the four modules. Ahead and turning left together: {words}.")

# %% [markdown]
# ## 4. From the body to the modules
#
# Two rows for each module, one matrix for all. You know them from chapter 02: a steered wheel is
# a wheel that measures forward and one that measures left.
#
# $$\begin{pmatrix} a_i \\ b_i \end{pmatrix} =
# \begin{pmatrix} 1 & 0 & -y_i \\ 0 & 1 & x_i \end{pmatrix}
# \begin{pmatrix} v_x \\ v_y \\ \omega \end{pmatrix}, \qquad
# u_i = \sqrt{a_i^2 + b_i^2}, \qquad \alpha_i = \operatorname{atan2}(b_i, a_i)$$
#
# **At rest** a wheel has no direction. atan2(0, 0) is 0, and every stop would swing all wheels
# ahead. So a module that stands still keeps the angle it has.

# %% [markdown]
# ### Exercise: speed and angle of each module (4 points)
#
# A module slower than `swerve.REST`, 0.1 mm/s, counts as still: speed 0, and the angle from
# `hold_angles`. Decide for each module. One can stand still while the others drive.


# %% exercise="swerve.module_targets"
def module_targets(drive, twist, hold_angles):
    """Speed and angle of each module for a twist of the body.

    drive : (m, 2) array, places of the modules [m, base]
    twist : (3,) array (vx, vy, omega) [m/s, m/s, rad/s; base]
    hold_angles : (m,) array, angles the modules have now [rad, base]
    returns : swerve.ModuleTargets(speeds=(m,) [m/s], angles=(m,) [rad, base])
    """
    ### BEGIN SOLUTION
    x, y = np.array(drive).T
    vx, vy, omega = twist
    a, b = vx - omega * y, vy + omega * x
    speeds = np.hypot(a, b)
    still = speeds < swerve.REST
    angles = np.where(still, hold_angles, np.arctan2(b, a))
    return swerve.ModuleTargets(np.where(still, 0.0, speeds), angles)
    ### END SOLUTION


# %% check="swerve.module_targets"
module_targets = check("swerve.module_targets")

# %% [markdown]
# **Two derivations, one result.** A thesis about a robot that won and a paper about the kinematics
# of one both come to this matrix (see *Reading*). The thesis writes the four $a$ first, then the
# four $b$, and its program goes front left, front right, rear left, rear right. The paper goes
# around, and begins with a velocity on the field. Sort the rows, and they agree.

# %%
command = np.array([0.8, -0.3, 1.5])
x, y = MODULES.T
one, none = np.ones(4), np.zeros(4)
thesis = np.vstack([np.c_[one, none, -y], np.c_[none, one, x]]) @ command
paper = np.vstack([[(1, 0, -place[1]), (0, 1, place[0])] for place in MODULES]) @ command
speeds, angles = module_targets(MODULES, command, np.zeros(4))
rows = {"thesis": (thesis[:4], thesis[4:]), "paper": (paper[0::2], paper[1::2])}
rows["ours"] = (speeds * np.cos(angles), speeds * np.sin(angles))
for name, (a, b) in rows.items():
    print(f"{name:6s} forward {a.round(3)}, left {b.round(3)} m/s")

# %% [markdown]
# ## 5. A command on the field
#
# Whoever steers thinks in the field: "to the far end", wherever the robot looks.
# The robot is turned by $\theta$. So its command is turned back by $\theta$:
#
# $$\begin{pmatrix} v_x \\ v_y \\ \omega \end{pmatrix}_{\!base} =
# \begin{pmatrix} \cos\theta & \sin\theta & 0 \\ -\sin\theta & \cos\theta & 0 \\ 0 & 0 & 1 \end{pmatrix}
# \begin{pmatrix} \dot x \\ \dot y \\ \dot\theta \end{pmatrix}_{\!map}$$

# %%
robots = []
for k, theta in enumerate(np.radians([0.0, 60.0, 150.0])):
    twist = swerve.field_to_robot([0.0, 1.5, 0.0], theta)
    speeds, angles = swerve.module_targets(MODULES, twist, np.zeros(4))
    robots.append(RobotPicture([1.7 + 1.3 * k, 1.4, theta], angles, speeds))
show(
    plots.draw_field(robot=robots, window=(1.1, 4.9, 0.7, 2.4)),
    "Three robots at headings 0°, 60° and 150° with the same command on the field, 1.5 m/s in y: "
    "their wheels point the same way on the field, and another way in each robot.",
)

# %% [markdown]
# ### Exercise: field to robot (1 point)


# %% exercise="swerve.field_to_robot"
def field_to_robot(twist, theta):
    """A velocity on the field, as the robot at heading theta has to drive it.

    twist : (3,) array (vx, vy, omega) [m/s, m/s, rad/s; map]
    theta : float [rad, map]
    returns : (3,) array [m/s, m/s, rad/s; base]
    """
    ### BEGIN SOLUTION
    c, s = np.cos(theta), np.sin(theta)
    vx, vy, omega = twist
    return np.array([c * vx + s * vy, c * vy - s * vx, omega])
    ### END SOLUTION


# %% check="swerve.field_to_robot"
field_to_robot = check("swerve.field_to_robot")

# %% [markdown]
# ## 6. Commands that motors can follow
#
# **The shorter turn.** A wheel at 180° that rolls backwards does the same as one at 0° that rolls
# forwards. So no module ever has to turn by more than 90°: beyond that, turn to the opposite angle
# and reverse the speed.
#
# The figure drives ahead at 1 m/s for a second, then backwards for a second.

# %%
paths = {}
for name, shorter in {"wrong: half a turn": False, "reference": True}.items():
    robot, poses = Simulator(start=(2.0, 2.0, 0.0)), []
    for t in np.arange(0.0, 2.2, 0.02):
        now, way = robot.read().module_angles, [1.0 if t < 1.0 else -1.0, 0.0, 0.0]
        targets = swerve.module_targets(MODULES, way, now)
        robot.apply(Command(*(swerve.shortest_turn(targets, now) if shorter else targets)))
        robot.step(0.02)
        poses.append(robot.truth.pose)
    paths[name] = np.array(poses)
aside = [1000 * np.ptp(path[:, 1]) for path in paths.values()]
show(
    plots.plot_paths(paths, markers={"start": (2.0, 2.0)}),
    f"One second ahead, one back. Steering by half a turn throws the robot {aside[0]:.0f} mm aside; "
    f"with the shorter turn it stays on its line within {aside[1]:.0f} mm.",
)

# %% [markdown]
# ### Exercise: the shorter turn (3 points)
#
# Angles come from everywhere. From 170° to −170° are 20°: wrap the difference first.
# `geometry.wrap_angle` is yours from chapter 00. Full turns of the result do not matter.


# %% exercise="swerve.shortest_turn"
def shortest_turn(targets, angles):
    """The same motion with at most a quarter turn of steering.

    targets : swerve.ModuleTargets, what the modules shall do
    angles : (m,) array, angles the modules have now [rad, base]
    returns : swerve.ModuleTargets, speeds with their sign
    """
    ### BEGIN SOLUTION
    turn = geometry.wrap_angle(targets.angles - angles)
    flip = np.abs(turn) > np.pi / 2
    speeds = np.where(flip, -targets.speeds, targets.speeds)
    return swerve.ModuleTargets(speeds, angles + np.where(flip, turn - np.pi, turn))
    ### END SOLUTION


# %% check="swerve.shortest_turn"
shortest_turn = check("swerve.shortest_turn")

# %% [markdown]
# **While a wheel still turns** to its angle, it pushes the wrong way. Multiply its speed by the
# cosine of what is left to turn: across its way a wheel stands still. This *cosine compensation*
# is one line, and the robot has it already: `swerve.cosine_compensation`.
#
# **The limit.** A motor reaches `max_speed` and no more. Ask for more, and every wheel that cannot
# follow is cut off by itself: the ratio of the speeds is lost, and the robot leaves its path.
# Slow all wheels by one factor instead. This is called *desaturation*.

# %%
wanted, times = np.array([2.0, 0.5, 3.0]), np.linspace(0.0, 0.9, 40)[:, None]
asked, cut = swerve.module_targets(MODULES, wanted, np.zeros(4)), 2.0
slower = swerve.limit_speeds(asked, cut)
driven = {
    "truth: wanted": wanted,
    "reference: one factor": swerve.body_twist(MODULES, *slower),
    "wrong: each cut off": swerve.body_twist(MODULES, np.minimum(asked.speeds, cut), asked.angles),
}
bends = [np.hypot(*twist[:2]) / twist[2] for twist in driven.values()]
show(
    plots.plot_paths({name: geometry.se2_exp(times * twist) for name, twist in driven.items()}),
    f"Asked for {asked.speeds.round(2)} m/s with a limit of {cut:g} m/s. Wanted is a bend of "
    f"{bends[0]:.2f} m radius; one factor keeps {bends[1]:.2f} m, cutting each wheel makes it {bends[2]:.2f} m.",
)

# %% [markdown]
# ### Exercise: limit the speeds (2 points)


# %% exercise="swerve.limit_speeds"
def limit_speeds(targets, max_speed):
    """All speeds slowed by one factor, so that the fastest module can follow.

    targets : swerve.ModuleTargets; negative speeds roll backwards
    max_speed : float [m/s]
    returns : swerve.ModuleTargets
    """
    ### BEGIN SOLUTION
    fastest = max(np.abs(targets.speeds).max(), max_speed)
    return swerve.ModuleTargets(targets.speeds * max_speed / fastest, targets.angles)
    ### END SOLUTION


# %% check="swerve.limit_speeds"
limit_speeds = check("swerve.limit_speeds")

# %% [markdown]
# ### Your number: the fastest turn (1 point)
#
# Your robot's wheels reach `world.max_speed`. It drives straight ahead at 1 m/s. How fast may it
# turn to the left meanwhile, before a wheel reaches its limit? In rad/s.

# %% answer="swerve.own_turn_rate"
answer(
    "swerve.own_turn_rate",
    ### BEGIN SOLUTION
    float((np.sqrt(2 * world.max_speed**2 - 1) - 1) / (2 * MODULES[0, 0])),
    ### END SOLUTION
)

# %% [markdown]
# ## 7. From the modules back to the body
#
# The encoders of four modules say eight numbers, $a_i = u_i \cos\alpha_i$ and $b_i = u_i \sin\alpha_i$. The motion
# has three. Eight equations, three unknowns: no twist fits all of them exactly.
# Least squares takes the one that fits best.
#
# $$\begin{pmatrix} 1 & 0 & -y_1 \\ \vdots & & \vdots \\ 0 & 1 & x_1 \\ \vdots & & \vdots \end{pmatrix}
# \begin{pmatrix} v_x \\ v_y \\ \omega \end{pmatrix} \approx
# \begin{pmatrix} a_1 \\ \vdots \\ b_1 \\ \vdots \end{pmatrix}$$

# %% [markdown]
# ### Exercise: the motion of the body (2 points)
#
# `np.linalg.lstsq(matrix, components, rcond=None)[0]` solves it.


# %% exercise="swerve.body_twist"
def body_twist(drive, speeds, angles):
    """The twist of the body that fits its modules best.

    drive : (m, 2) array, places of the modules [m, base]
    speeds : (m,) array [m/s]
    angles : (m,) array [rad, base]
    returns : (3,) array (vx, vy, omega) [m/s, m/s, rad/s; base]
    """
    ### BEGIN SOLUTION
    x, y = np.array(drive).T
    one, zero = np.ones(len(x)), np.zeros(len(x))
    matrix = np.vstack([np.c_[one, zero, -y], np.c_[zero, one, x]])
    components = np.hstack([speeds * np.cos(angles), speeds * np.sin(angles)])
    return np.linalg.lstsq(matrix, components, rcond=None)[0]
    ### END SOLUTION


# %% check="swerve.body_twist"
body_twist = check("swerve.body_twist")

# %% [markdown]
# ### What is left over
#
# Wheels that roll agree but for noise. A wheel that slips does not. The *residual* is how far the
# wheels differ from the motion that fits best, on average:
#
# $$\text{residual} = \sqrt{\frac{1}{m} \sum_i \big[(a_i - \hat a_i)^2 + (b_i - \hat b_i)^2\big]}$$
#
# It needs no other sensor. It says *that* a wheel slips; the challenge asks *which*.

# %%
wet = worlds.slip_log(worlds.generator(student, "wet floor"))
residual = swerve.body_motion(MODULES, wet.speeds, wet.angles).residual
slips = wet.slipping >= 0
fig, ax = figure(7.5, 3.0)
ax.fill_between(
    wet.time, 0, 0.25, where=slips, color=plots.WARN, alpha=0.2, step="mid", label="a wheel slips"
)
ax.plot(wet.time, residual, color=plots.MINE, linewidth=1.0, label="residual")
ax.set(xlabel="time [s]", ylabel="residual [m/s]", xlim=(0, 12), ylim=(0, 0.25))
ax.legend(loc="upper right", ncols=2)
show(
    fig,
    f"Residual of the wheels over 12 s on a floor with wet spots: {residual[~slips].mean():.3f} m/s "
    f"while all roll, {residual[slips].mean():.3f} m/s while one slips.",
)

# %% [markdown]
# ### Your number: a crooked encoder (1 point)
#
# Steering encoders are screwed on by hand. Each has a *zero offset*: it says so much too much.
# A camera over the field saw how your robot moved: `world.twists`. The encoders said
# `world.angles`, shape (600, 4). What is the offset of the **rear right** module, in degrees?
#
# For each row, your own part says which angles the modules must really have had. Wrap the
# differences before you average.

# %%
true_angles = np.array([module_targets(MODULES, t, np.zeros(4)).angles for t in world.twists])
print(
    f"row 0: encoders {np.degrees(world.angles[0]).round(1)}°, camera {np.degrees(true_angles[0]).round(1)}°"
)

# %% answer="swerve.own_offset"
answer(
    "swerve.own_offset",
    ### BEGIN SOLUTION
    float(np.degrees(geometry.wrap_angle(world.angles - true_angles)[:, 2].mean())),
    ### END SOLUTION
)

# %% [markdown]
# ## 8. A command holds for a while
#
# A command lasts until the next one. Meanwhile the robot turns, and "ahead" turns with it. Someone
# who orders "straight along the field, while turning" gets a drift to the side. This is *skew*.
#
# The remedy is exact. Over $\Delta t$ the robot turns by $\omega \Delta t$; call half of it $h$.
# It drives an arc whose chord points $h$ to the left of the start. So aim $h$ to the right.
# And an arc is longer than its chord:
#
# $$h = \frac{\omega\,\Delta t}{2}, \qquad
# \begin{pmatrix} v_x \\ v_y \end{pmatrix} \leftarrow \frac{h}{\sin h}
# \begin{pmatrix} \cos h & \sin h \\ -\sin h & \cos h \end{pmatrix}
# \begin{pmatrix} v_x \\ v_y \end{pmatrix}$$

# %%
paths, aims = {}, {"wrong: as it comes": lambda twist, dt: twist, "reference": swerve.discretize}
for name, aim in aims.items():
    pose = [np.zeros(3)]
    for _ in range(20):
        twist = aim(swerve.field_to_robot([1.0, 0.0, 3.0], pose[-1][2]), 0.1)
        pose.append(geometry.compose(pose[-1], geometry.se2_exp(0.1 * twist)))
    paths[name] = np.array(pose)
drift = [path[-1, 1] for path in paths.values()]
show(
    plots.plot_paths(paths, headings=8),
    "Ordered: 1 m/s along the field's x while turning at 3 rad/s, a new command every 0.1 s. As it "
    f"comes, the robot is {drift[0]:.2f} m aside after 2 s; aimed before the turn {abs(drift[1]):.2f} m.",
)

# %% [markdown]
# ### Exercise: discretize (2 points)
#
# Write it with sine and cosine. It must work at $\omega = 0$, where $h / \sin h$ is 1.
# `np.sinc(z)` is $\sin(\pi z) / (\pi z)$, and knows what to do at 0.


# %% exercise="swerve.discretize"
def discretize(twist, dt):
    """The twist to command so that after dt the robot is where the wanted one meant.

    twist : (3,) array (vx, vy, omega) [m/s, m/s, rad/s; base at the start of the step]
    dt : float [s]
    returns : (3,) array [m/s, m/s, rad/s; base]
    """
    ### BEGIN SOLUTION
    vx, vy, omega = twist
    h = omega * dt / 2
    longer = 1 / np.sinc(h / np.pi)
    c, s = longer * np.cos(h), longer * np.sin(h)
    return np.array([c * vx + s * vy, c * vy - s * vx, omega])
    ### END SOLUTION


# %% check="swerve.discretize"
discretize = check("swerve.discretize")

# %% [markdown]
# ## 9. To a target
#
# The error is where I am minus where I should be: $e = x - x^*$. Let it fade at a constant rate:
#
# $$\dot e = -\lambda e \quad\Rightarrow\quad e(t) = e(0)\, e^{-\lambda t}$$
#
# All three components fade alike, so the path to a still target is a straight line. Since
# $\dot e = \dot x - \dot x^*$, the velocity on the field has to be
#
# $$\xi = -\lambda (x - x^*) + \dot x^*$$
#
# The last term is the target's own velocity, the **feed-forward**. It is 0 for a target that
# stands.

# %% [markdown]
# ### Exercise: pose feedback (2 points)
#
# The heading's error is an angle: wrap it, and the robot turns the shorter way.


# %% exercise="swerve.pose_feedback"
def pose_feedback(pose, target, gain, feedforward=(0.0, 0.0, 0.0)):
    """The velocity on the field that makes the error fade like exp(-gain t).

    pose, target : (3,) arrays (x, y, theta) [m, m, rad; map]
    gain : float [1/s]
    feedforward : (3,) array, the target's own velocity [m/s, m/s, rad/s; map]
    returns : (3,) array [m/s, m/s, rad/s; map]
    """
    ### BEGIN SOLUTION
    error = np.array(pose) - np.array(target)
    error[2] = geometry.wrap_angle(error[2])
    return np.array(feedforward) - gain * error
    ### END SOLUTION


# %% check="swerve.pose_feedback"
pose_feedback = check("swerve.pose_feedback")

# %% [markdown]
# ### The paper's first figure: a still target
#
# From (0, 0, 0°) to (3, 6, 90°) within 12 s, a step every 0.01 s. Robot without mass. The four
# panels are the paper's: errors, wheel speeds, steering, path. It prints no gain and no wheel
# speeds; with $\lambda = 0.5$ /s the error is gone after 12 s, as in its figure. Our wheels reach
# 3.2 m/s: is that enough for the start?


# %%
def draw_path(ax, log):
    """The path of a run with headings, over that of its target."""
    style = "-" if np.ptp(log.targets, axis=0).any() else "*"
    ax.plot(*log.targets[:, :2].T, style, color=plots.REFERENCE, linewidth=5, alpha=0.4)
    ax.plot(*log.poses[:, :2].T, color=plots.MINE)
    x, y, theta = log.poses[::60].T
    ax.quiver(x, y, np.cos(theta), np.sin(theta), color="0.5", scale=16, width=0.006)
    ax.set(aspect="equal", adjustable="datalim", title="(d) path [m]")


# %%
def four_panels(log):
    """Errors, wheel speeds, steering angles and path of a run, as the paper shows them."""
    fig, ((error, speed), (steer, path)) = figure(8.2, 5.4, 2, 2, sharex=False)
    for k, name in enumerate(("x [m]", "y [m]", "heading [rad]")):
        error.plot(log.time, log.errors[:, k], color=plots.XYZ[k], label=name)
    speed.plot(log.time, log.speeds, label=WHEELS)
    steer.plot(log.time, np.degrees(np.unwrap(log.angles, axis=0)))
    draw_path(path, log)
    for ax, title in zip(
        (error, speed, steer), ("(a) error", "(b) wheel speed [m/s]", "(c) steering [deg]")
    ):
        ax.set(title=title, xlabel="time [s]")
    error.legend()
    speed.legend()
    return fig


# %%
still = swerve.follow(MODULES, (0.0, 0.0, 0.0), (3.0, 6.0, np.pi / 2), gain=0.5)
print(
    f"At the start the wheels roll at {still.speeds[0].round(2)} m/s, at {np.degrees(still.angles[0]).round(1)}°"
)
show(
    four_panels(still),
    f"A still target: after 12 s the robot is {1000 * np.hypot(*still.errors[-1, :2]):.0f} mm and "
    f"{np.degrees(abs(still.errors[-1, 2])):.1f}° from it. The path leaves the straight line by "
    f"{1000 * np.abs(still.poses[:, 1] - 2 * still.poses[:, 0]).max():.1f} mm.",
)

# %% [markdown]
# ### The second figure: a target that moves
#
# A figure eight, with the heading along the path. The print lets it go round once a *second*,
# which takes wheels of 9.8 m/s. Here one round takes 12 s. In the tight bends the modules steer
# fast.
#
# **Task.** Choose the circle, of radius 2 m. Then take the feed-forward away, as the paper does.
# Which panel shows what is missing? How far does a larger gain help?


# %%
rounds = {
    "figure eight": lambda t: swerve.figure_eight(t, period=12.0),
    "circle": lambda t: swerve.circle(t, period=12.0),
}


# %%
def draw_following(path, feedforward, gain):
    """The four panels for one moving target, from (0, 0, 0)."""
    feed = feedforward == "with"
    start = (0.0, 0.0, 0.0)
    run = swerve.follow(MODULES, start, rounds[path], gain=gain, dt=0.02, feedforward=feed)
    far = 1000 * np.hypot(*run.errors[300:, :2].T).max()
    return four_panels(run), (
        f"A {path} {feedforward} feed-forward, gain {gain:g} /s: after 6 s the robot is within "
        f"{far:.0f} mm of its target."
    )


explore(
    draw_following,
    path=["figure eight", "circle"],
    feedforward=["with", "without"],
    gain=(0.5, 5.0, 0.5, 1.0),
)

# %% [markdown]
# The circle as printed, without feed-forward: the errors of x and y never end, and the robot drives
# a smaller circle.

# %%
show(*draw_following("circle", "without", 1.0))

# %% [markdown]
# How far is each from its target, with and without?

# %%
fig, panels = figure(8.2, 3.0, columns=2, sharey=True)
ways, lag = {"as printed": (False, plots.WARN), "with feed-forward": (True, plots.REFERENCE)}, []
for ax, (name, target) in zip(panels, rounds.items()):
    for words, (feed, colour) in ways.items():
        start = target(np.zeros(1)).pose[0]
        log = swerve.follow(MODULES, start, target, gain=1.0, dt=0.02, feedforward=feed)
        far = np.hypot(*log.errors[:, :2].T)
        lag.append(far[300:].mean())
        ax.plot(log.time, far, color=colour, label=words)
    ax.set(title=f"{name}: off the target [m]", xlabel="time [s]")
panels[1].legend(loc="center right")
show(
    fig,
    f"Distance to the target with gain 1 /s. As printed {lag[0]:.2f} m on the eight and {lag[2]:.2f} m "
    f"on the circle, with feed-forward {1000 * lag[1]:.1f} mm and {1000 * lag[3]:.1f} mm.",
)

# %% [markdown]
# The circle's target runs at $2\pi \cdot 2\,\mathrm{m} / 12\,\mathrm{s} = 1.05$ m/s. Without
# feed-forward the robot lags by about speed / gain; it cuts the bend, so it is a little less.
# A larger gain lags less. But motors lag too, and a large gain makes them swing.

# %% [markdown]
# ## 10. Play: one point that stands still
#
# All wheels stand across the line to one point: the **centre of rotation**, the orange dot. The
# body turns about it.
#
# **Task.** Let $\omega$ be 2 rad/s, and bring the dot onto the front left wheel. Which $v_x$ and
# $v_y$ does that take, and what does its module do then?


# %%
def draw_twist(vx, vy, omega):
    """Arrows of the modules for one twist, by your own part, and the centre of rotation."""
    fig, ax = figure(5.0, 4.3)
    targets = module_targets(MODULES, np.array([vx, vy, omega]), np.zeros(4))
    words = draw_arrows(ax, targets, f"vx {vx:g} m/s, vy {vy:g} m/s, omega {omega:g} rad/s")
    where = "It drives straight: there is no centre of rotation."
    if omega:
        x, y = -vy / omega, vx / omega
        ax.plot(x, y, "o", color=plots.WARN, markersize=9)
        where = f"The centre of rotation is at x {x:.2f}, y {y:.2f} m."
    return fig, f"{where} Front left, rear left, rear right, front right: {words}."


explore(
    draw_twist, vx=(-1.5, 1.5, 0.01, 0.8), vy=(-1.5, 1.5, 0.01, 0.2), omega=(-4.0, 4.0, 0.1, 1.5)
)

# %% [markdown]
# ## 11. Break it
#
# The eight of section 2 again, one failure at a time, on the course's parts. Two numbers count: how
# far the robot is off, and how fast the tyres scrub over the floor.

# %%
swap, crooked = [0, 3, 2, 1], np.radians([0.0, 0.0, 20.0, 0.0])
failures = {
    "all in order": run(course),
    "an encoder 20° off": run(course, spoil=lambda speeds, angles: (speeds, angles + crooked)),
    "a drive motor dead": run(course, spoil=lambda speeds, angles: (speeds * [1, 1, 0, 1], angles)),
    "feed-forward left out": run(
        replace(course, pose_feedback=lambda p, t, g, f: swerve.pose_feedback(p, t, g))
    ),
    "pose 0.2 s old": run(course, delay=10),
    "wet floor": run(course, model=RobotModel(friction=0.15)),
}

# %% [markdown]
# **An encoder off, a motor dead.** Feedback pulls the robot back to its path, and nobody notices.
# But the wheels fight each other: tyres, battery and odometry pay. The residual of section 7 finds
# the motor. The encoder leaves 0.03 m/s, no more than the noise in section 7: to find it takes
# another sensor, like the camera there.

# %%
for name, lie in {
    "all in order": 0.0,
    "a drive motor dead": 0.0,
    "an encoder 20° off": crooked,
}.items():
    said = failures[name]
    residual = swerve.body_motion(MODULES, said[4], said[3] - lie).residual.mean()
    print(f"{name:20s} residual {residual:.3f} m/s")

# %% [markdown]
# **Old poses.** Feedback corrects an error that is gone already, and overshoots.
#
# **Wet floor.** Wheels that spin push less, not more.
#
# **Swapped modules, degrees, wrong axes.** The robot leaves at once. These are found in the first
# minute on the floor, if somebody stands beside the stop button.

# %%
failures["modules swapped"] = run(course, spoil=lambda speeds, angles: (speeds[swap], angles[swap]))
failures["angles in degrees"] = run(
    course, spoil=lambda speeds, angles: (speeds, np.degrees(angles))
)
failures["slow loop, 0.2 s"] = run(course, dt=0.2)
failures["0.2 s, no discretize"] = run(replace(course, discretize=lambda twist, dt: twist), dt=0.2)
failures["robot's axes for the field's"] = run(
    replace(course, field_to_robot=lambda twist, theta: twist)
)
table = {name: (distance(log), log[5].mean()) for name, log in failures.items()}
for name, (off, scrub) in table.items():
    print(f"{name:29s} {off:6.0f} mm off, tyres scrub at {scrub:.2f} m/s")


# %%
fig, panels = figure(8.2, 3.9, columns=2, sharey=True)
names = list(table)[::-1]
columns = ("off the target [mm]", 60.0, "{:.0f}"), ("tyres scrub [m/s]", 0.05, "{:.2f}")
for k, (ax, (words, limit, form)) in enumerate(zip(panels, columns)):
    values = np.array([table[name][k] for name in names])
    ax.scatter(values, names, s=60, color=np.where(values > limit, plots.WARN, plots.REFERENCE))
    ax.set(title=words, xscale="log", xlim=(values.min() / 2, values.max() * 6))
    for row, value in enumerate(values):
        ax.text(1.4 * value, row, form.format(value), va="center")
good, hidden = table["all in order"], table["an encoder 20° off"]
show(
    fig,
    f"Eleven runs. In order the robot is {good[0]:.0f} mm off and scrubs at {good[1]:.2f} m/s; with an "
    f"encoder 20° off it is {hidden[0]:.0f} mm off and scrubs at {hidden[1]:.2f} m/s.",
)

# %% [markdown]
# ## 12. Check the source
#
# **A rotation the wrong way.** The paper turns the field's velocity into the robot's axes. Its
# equation 17 has the right matrix. Equations 15 and 18 print the opposite rotation, from the robot
# to the field, and 28 has none. At heading 0 all three are the same, so a first test passes.


# %%
def lead(sign):
    """Path to (3, 6, 90°) when the field's velocity is turned by sign times the heading."""
    pose, path = np.zeros(3), []
    for _ in range(450):
        path.append(pose)
        wanted = swerve.pose_feedback(pose, [3.0, 6.0, np.pi / 2], 0.5)
        twist = swerve.field_to_robot(wanted, -sign * pose[2])
        pose = geometry.compose(pose, 0.01 * twist)
    return np.array(path)


# %%
printed = {"wrong: (15), (18)": lead(1), "no rotation: (28)": lead(0), "reference: (17)": lead(-1)}
ends = [np.hypot(*(path[-1, :2] - [3.0, 6.0])) for path in printed.values()]
fig = plots.plot_paths(printed, markers={"target": (3.0, 6.0)}, headings=9)
show(
    fig,
    f"To (3, 6, 90°) for 4.5 s. Equation 17 leads straight there, {ends[2]:.2f} m are left. Equations 15 "
    f"and 18 drive it away, to {ends[0]:.2f} m; without rotation (28) {ends[1]:.2f} m are left.",
)

# %% [markdown]
# **The heading along a path.** Printed is $\theta^* = \arctan(\dot x + \dot y)$ (29), and a
# derivative that divides by $\dot x + \dot y$ (31). Right are
#
# $$\theta^* = \operatorname{atan2}(\dot y, \dot x), \qquad
# \dot\theta^* = \frac{\dot x\, \ddot y - \dot y\, \ddot x}{\dot x^2 + \dot y^2}$$

# %%
t = np.linspace(0.0, 1.0, 1001)
right = swerve.figure_eight(t)
dx, dy = right.twist[:, :2].T
ddx, ddy = -2.8 * np.pi**2 * np.sin(2 * np.pi * t), -11.2 * np.pi**2 * np.sin(4 * np.pi * t)
turning = (dx * ddy - dy * ddx) / (dx + dy)
poles = np.sum(np.diff(np.sign(dx + dy)) != 0)
fig, (heading, rate) = figure(8.2, 3.0, columns=2)
heading.plot(t, np.degrees(right.pose[:, 2]), color=plots.REFERENCE, label="atan2")
heading.plot(t, np.degrees(np.arctan(dx + dy)), color=plots.WARN, label="(29)")
rate.plot(t, right.twist[:, 2], color=plots.REFERENCE, label="right")
rate.plot(t, turning, color=plots.WARN, label="(31)")
low, high = np.degrees([right.pose[:, 2].min(), right.pose[:, 2].max()])

# %%
heading.set(title="heading on the eight [deg]", xlabel="time [s]")
rate.set(title="turn rate [rad/s]", ylim=(-150, 150), xlabel="time [s]")
heading.legend()
rate.legend(loc="lower right")
show(
    fig,
    f"Heading on the figure eight: atan2 runs from {low:.0f}° to {high:.0f}°, equation 29 never leaves "
    f"±90°. The robot turns by at most {np.abs(right.twist[:, 2]).max():.1f} rad/s; equation 31 goes to "
    f"infinity {poles} times a round.",
)

# %% [markdown]
# **Factors of π.** Each derivative of $\sin(2\pi t)$ brings a $2\pi$. In equations 35 to 37 some got
# lost. The difference quotient shows how much.

# %%
step, t = 1e-4, 0.04
y_of = {"circle": lambda t: 2 * np.sin(2 * np.pi * t)}
y_of["eight"] = lambda t: 0.9 + 0.7 * np.sin(4 * np.pi * t)
first = {"circle": 2 * np.cos(2 * np.pi * t), "eight": 2.8 * np.cos(4 * np.pi * t)}
second = {"circle": -8 * np.sin(2 * np.pi * t), "eight": -4.6 * np.sin(4 * np.pi * t)}
for name, y in y_of.items():
    before, now, after = y(t - step), y(t), y(t + step)
    true = (after - before) / (2 * step), (after - 2 * now + before) / step**2
    for what, shown, right in zip(("y' ", "y''"), (first[name], second[name]), true):
        print(
            f"{name:6s} {what} printed {shown:7.3f}, right {right:8.3f}, factor {right / shown:6.3f}"
        )

# %% [markdown]
# **The stop that does not stop.** The thesis prints its drive program. With the command (0, 0, 0) it
# sets four angles and no speed, so the wheels keep rolling. And it hands the rear left module the
# front right module's angle, and the other way round: from tick to tick the two chase each other,
# until they meet in between. Rear left and front right are numbers 1 and 3.


# %%
def stopping(stop):
    """Pose at the moment of the stop and one second later, after a second of a left bend."""
    robot, poses, speeds = Simulator(start=(3.0, 2.0, 0.0)), [], np.zeros(4)
    for t in np.arange(0.0, 2.0, 0.02):
        now = robot.read().module_angles
        if t < 1.0:
            speeds, angles = swerve.module_targets(MODULES, [0.8, 0.0, 1.5], now)
        else:
            speeds, angles = stop(speeds, now)
        robot.apply(Command(speeds, angles))
        robot.step(0.02)
        poses.append(robot.truth.pose)
    return np.array(poses)


# %%
stops = {
    "wrong: as printed": stopping(lambda speeds, now: (speeds, now[[0, 3, 2, 1]])),
    "reference": stopping(lambda speeds, now: (np.zeros(4), now)),
}
ways = [np.hypot(*np.diff(path[50:, :2], axis=0).T).sum() for path in stops.values()]
show(
    plots.plot_paths(stops, markers={"stop": stops["reference"][49, :2]}, headings=8),
    "A left bend for one second, then the command (0, 0, 0). In the second after it the robot rolls "
    f"on for {ways[0]:.2f} m as printed, and for {ways[1]:.2f} m on our parts.",
)

# %% [markdown]
# More that does not hold in print:
#
# | where | printed | what it does |
# |---|---|---|
# | paper (21) | $\arctan(\dot y / \dot x)$ | backwards comes out as ahead; section 4 uses atan2 |
# | paper (27), moving target | no feed-forward | lags by speed / gain; section 9 |
# | paper (32), (33) | one round a second | 12.6 m/s on the circle; our wheels do 3.2 |
# | paper, on its figure 7 | bends at t = 8, 20, 31 and 43 | its run ends at 12 s |
# | paper (34), (36) | $\ddot x$ without its factor of π too | as above |
# | thesis, drive program | modules 1 m out, limit 1 | speeds are shares of a limit, not m/s |
# | thesis, drive program | angle as it comes | steers up to half a turn; section 6 |

# %% [markdown]
# ## 13. Link-up: your parts in the robot
#
# Three rungs. *Ideal*: motors without lag, a floor that grips. *Real*: your own robot.
# *Rough*: a slippery floor, slow motors, and poses that arrive 0.1 s late. Each runs once on the
# course's parts and once on yours, as far as they were accepted.

# %%
mine, own = robot_parts("mixed"), worlds.own_robot(student)
quick = {"steering_lag": 0.0, "drive_lag": 0.0, "steering_rate": 1e3}
strong = {"drive_acceleration": 1e3, "drive_force": 1e3, "friction": 3.0}
ideal = replace(own, **quick, **strong)
slow = replace(own, steering_lag=0.12, drive_lag=0.12, friction=0.3)
rungs = {"ideal": (ideal, 0), "real": (own, 0), "rough": (slow, 5)}
print(f"Parts: {mine.label}")
logs = {}
for name, (model, delay) in rungs.items():
    ours, yours = (run(parts, model=model, delay=delay) for parts in (course, mine))
    logs[name] = ours, yours
    print(
        f"{name:6s} {distance(ours):4.0f} mm off on the course's parts, {distance(yours):4.0f} mm on yours"
    )

# %%
ours, yours = logs["rough"]
paths = {"truth: target": ours[2], "reference": ours[1]} | ({"mine": yours[1]} if mine.mine else {})
show(
    plots.draw_field(paths, RobotPicture(yours[1][-1], yours[3][-1], yours[4][-1])),
    f"The rough rung on the course's parts and on yours ({mine.label}): {distance(ours):.0f} mm and "
    f"{distance(yours):.0f} mm from the target on average.",
)

# %% [markdown]
# The target starts at full speed. On the slippery floor the robot needs most of the first loop to
# catch up. What the modules did meanwhile, on your parts: a negative speed is a wheel that took the
# shorter turn.

# %%
backwards = 100 * (yours[4] < -0.02).mean()
show(
    plots.plot_modules(yours[0], yours[3], yours[4]),
    f"Angles and speeds of the four modules on the rough rung: up to {np.abs(yours[4]).max():.2f} m/s, "
    f"{backwards:.0f} % of the time backwards.",
)

# %% [markdown]
# ## 14. Drive it yourself
#
# Press the button and use the sliders, or a gamepad. Your accepted parts drive the modules.
#
# **Task.** From the start drive 1 m to the left, away from the grey rack. Drive a square of 1 m
# without turning the robot. Then turn it once around its own rear left wheel.

# %%
drive(robot_parts("mixed"))

# %% [markdown]
# ## 15. Challenge: which wheel slips? (4 points)
#
# A drive of 12 s over a floor with wet spots, 50 rows a second. Encoders say speeds and angles, with
# noise. In each row say which module slips: 0 to 3, or −1 where all roll. Never do two slip at once.
# A wheel that slips is 0.15 to 0.45 m/s too fast or too slow, for a quarter of a second or longer.
#
# It is judged by the share of wrong rows in the worst of three drives: up to 4 % earns all
# points, up to 16 % half of them. Saying −1 everywhere is wrong in about a third.
#
# Ideas: what is left over of each wheel after the best fit? Noise changes from row to row, slip
# does not. How small a slip can you tell from noise?


# %% exercise="swerve.find_slip"
def find_slip(drive, speeds, angles):
    """The module that slips at each moment of a log.

    drive : (m, 2) array, places of the modules [m, base]
    speeds : (n, m) array [m/s]
    angles : (n, m) array [rad, base]
    returns : (n,) array of whole numbers: 0 to m - 1, or -1 where all roll
    """
    ### BEGIN SOLUTION
    x, y = np.array(drive).T
    one, zero = np.ones(len(x)), np.zeros(len(x))
    matrix = np.vstack([np.c_[one, zero, -y], np.c_[zero, one, x]])
    seen = np.hstack([speeds * np.cos(angles), speeds * np.sin(angles)])
    left_over = seen - seen @ np.linalg.pinv(matrix).T @ matrix.T
    doubt = np.hypot(left_over[:, : len(x)], left_over[:, len(x) :])
    padded = np.pad(doubt, ((3, 3), (0, 0)), mode="edge")
    doubt = np.median([padded[k : k + len(seen)] for k in range(7)], axis=0)
    return np.where(doubt.max(axis=1) > 0.07, doubt.argmax(axis=1), -1)
    ### END SOLUTION


# %% check="swerve.find_slip"
find_slip = check("swerve.find_slip")

# %%
found = find_slip(MODULES, wet.speeds, wet.angles)
wrong = found != wet.slipping
fig, ax = figure(7.5, 2.6)
ax.step(wet.time, wet.slipping, color=plots.TRUTH, alpha=0.35, linewidth=4, label="truth")
ax.step(wet.time, found, color=plots.MINE, linewidth=1.2, label="found")
ax.set(xlabel="time [s]", xlim=(0, 12), ylim=(-1.6, 4.4))
ax.set_yticks(range(-1, 4), ["none", *WHEELS])
ax.legend(loc="upper right", ncols=2)
show(
    fig,
    f"Which wheel slips on the wet floor of section 7: {100 * wrong.mean():.1f} % of the rows are wrong.",
)

# %% [markdown]
# ## 16. Summary
#
# - Each module moves with the velocity of its own place: $v + \omega \times r$.
# - Commands on the field are turned back by the heading, and aimed before the turn.
# - Turn the shorter way, slow all wheels by one factor, keep angles at rest.
# - Least squares gives the motion back; what is left over shows slip.
# - Feedback fades the error, feed-forward keeps up with the target.
#
# **Ask yourself.** Where is the centre of rotation when $\omega = 0$? Why can two modules not tell
# which of them slips? Why does feedback hide a crooked encoder, and what still shows it? When does
# a module have to turn by exactly 90°? Why is the path to a still target straight?
#
# ## Glossary
#
# | English | Bahasa Indonesia |
# |---|---|
# | swerve module | modul swerve |
# | steering angle | sudut kemudi |
# | twist | kecepatan badan (linier dan sudut) |
# | inverse kinematics | kinematika invers |
# | forward kinematics | kinematika maju |
# | least squares | kuadrat terkecil |
# | residual | sisa, residu |
# | slip | selip |
# | feedback | umpan balik |
# | feed-forward | umpan maju |
# | gain | penguatan |
# | target | sasaran |
#
# ## Reading
#
# WPILib documentation, *Swerve Drive Kinematics*: the same steps in a library that many teams use.
#
# Sources of the two derivations and of the printed formulas: I. Siradjuddin, S. Wibowo, A. Rofiq, on
# the kinematics of a four-wheel swerve robot, Politeknik Negeri Malang, 2022; and the thesis on a
# swerve-drive robot of Universitas Negeri Yogyakarta, 2024, chapter "Kinematika Swerve Drive".
#
# ## Where you are

# %%
status()

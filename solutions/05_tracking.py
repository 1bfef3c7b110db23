# %% [markdown]
# # 05 · Tracking: stay on the path
#
# You have a path. Now drive it: steer towards a point a little ahead, as fast as bends and brakes
# allow, and let a controller remove what goes wrong. At the end your robot drives from the start
# zone to Area 3 by itself.
#
# | | |
# |---|---|
# | Time | 4 hours |
# | You need | chapters 00 and 04; arctangent, derivative, integral |
# | Points | 22: six functions, two numbers, one challenge |
# | Your robot gains | `speed_profile`, `nearest_point`, `pure_pursuit`, `pid_step` |

# %%
import itertools

import numpy as np

from robocon_course import field, geometry, tracking, worlds
from robocon_course.autopilot import (
    Following,
    FollowSettings,
    Route,
    follow_step,
    module_command,
)
from robocon_course.exercises import answer, begin, check, hint, robot_parts, status
from robocon_course.simulator import Simulator, warm_up
from robocon_course.tracking import Cart, Faults, PidGains, PidLimits, PidState, TrackingSettings
from robocon_course.view import animate, explore, figure, pictures, plots, show

student = begin("tracking", student=None)  # None: the number you gave in chapter 00
world = worlds.practice_world(student)

# %% [markdown]
# ## 1. Where this part sits

# %%
show(
    pictures.draw_system(here="05"),
    "Pursuit and PID stand between the path and the body twist: a path and a pose go in, a velocity "
    "comes out.",
)

# %% [markdown]
# ## 2. See it work
#
# A figure eight on the field, at up to 2 m/s. The robot drives towards a point of the path a little
# ahead, and does not turn meanwhile: a swerve drive may go sideways. First the path, and the speed
# at each of its points.

# %%
turn = np.linspace(0.0, 2 * np.pi, 400)
eight = np.column_stack([3.2 + 1.4 * np.sin(turn), 2.0 + 0.7 * np.sin(2 * turn)])
eight_speeds = tracking.speed_profile(eight, 2.0, 2.0, 2.0)
round_trip = Route(eight, geometry.distance_along(eight), eight_speeds)


# %% [markdown]
# The robot's law is `autopilot.follow_step`: from path, speeds and pose to a velocity on the field.
# Section 13 explains it. You build its four parts: `nearest_point`, `pure_pursuit`, `pid_step`,
# `speed_profile`.


# %%
def steer(parts, route, settings=FollowSettings()):
    """Drive a path in the simulator: time, poses, course, module angles and speeds, cross-track."""
    robot, rows, state = Simulator(start=(*route.xy[0], 0.0)), [], Following.begin(route)
    while state.left > 0.01 and len(rows) < 2000:
        now, pose = robot.read(), robot.truth.pose
        state = follow_step(parts, state, route, pose, 0.02, settings=settings)
        seen = now.time, pose, state.course, now.module_angles, now.module_speeds
        rows.append((*seen, state.across.measured))
        robot.apply(module_command(parts, state.twist, pose[2], now.module_angles, dt=0.02))
        robot.step(0.02)
    return [np.array(column) for column in zip(*rows)]


warm_up()

# %%
log = steer(robot_parts("reference"), round_trip)
off = 1000 * np.abs(log[5])
moving = animate(log[0], {"reference": log[1]}, angles=log[3], speeds=log[4], frames=40)
show(
    moving,
    f"The robot drives a figure eight of {geometry.distance_along(eight)[-1]:.1f} m in {log[0][-1]:.1f} s, at most "
    f"{off.max():.0f} mm beside it, and always faces the same way.",
)

# %% [markdown]
# ## 3. The PID controller
#
# Something shall have a value, the **setpoint**. It has another one, the **measurement** $y$. The
# difference is the **error** $e$. From it a controller makes an **output** $u$, three ways at once:
#
# $$u = \underbrace{k_p\, e}_{\text{what is wrong now}}
#   + \underbrace{k_i \textstyle\int e\,dt}_{\text{what stays wrong}}
#   - \underbrace{k_d\, \dot y}_{\text{brake}}$$
#
# | symbol | meaning | unit |
# |---|---|---|
# | $e$ | setpoint minus measurement | here rad |
# | $u$ `output` | here: by how much the right wheel is faster than the left | m/s |
# | $k_p, k_i, k_d$ `gains` | strength of the three terms | m/s per rad; m/s per (rad s); m/s per (rad/s) |
# | `limits` | least and greatest output | m/s |
# | $\Delta t$ `dt` | time since the sample before | s |
#
# The examples steer a **cart**: two driven wheels, 30 cm apart, that reach their speed with a lag of
# 70 ms. It drives at 0.25 m/s and shall turn to a heading. And one of its tyres is soft: it pulls to
# the right by 0.5 rad/s.


# %%
def turn_to(heading, gains, limits=PidLimits(-0.6, 0.6), *, pull=0.0, step=None, seconds=3.0):
    """A cart turns to a heading at t = 0.2 s: its heading and the output, every 10 ms."""
    cart, state, rows = Cart(), PidState(), []
    step = step or tracking.pid_step
    for k in range(round(100 * seconds)):
        goal = heading if k >= 20 else 0.0
        state = step(state, goal, cart.pose[2], 0.01, gains, limits)
        cart.drive(0.25, state.output / cart.model.wheel_base - pull)
        rows.append((cart.pose[2], state.output))
    return np.array(rows).T


# %%
kinds = {"P": PidGains(0.9), "PI": PidGains(0.9, 1.5), "PID": PidGains(3.0, 6.0, 0.1)}
answers = {name: turn_to(1.0, gains, pull=0.5) for name, gains in kinds.items()}
time = 0.01 * np.arange(300)
goal = np.where(time < 0.2, 0.0, np.degrees(1.0))
headings = {name: np.degrees(heading) for name, (heading, _) in answers.items()}
title = "Heading [deg]"
show(
    plots.plot_responses(time, {title: headings}, targets={title: goal}),
    f"Told to turn by 57°. P alone ends at {headings['P'][-1]:.0f}°: the soft tyre wins. PI goes up to "
    f"{headings['PI'].max():.0f}° and ends at {headings['PI'][-1]:.0f}°. PID, with larger gains, goes up to "
    f"{headings['PID'].max():.0f}° and ends at {headings['PID'][-1]:.0f}°.",
)

# %% [markdown]
# **P** needs an error to push at all. Against a steady pull it stays off by pull · base / $k_p$.
#
# **I** adds up the error until it is gone. But it has to be emptied again, by an error of the other
# sign: it overshoots.
#
# **D** sees the target come near and brakes. With it the other two may be larger.
#
# ### What goes wrong in a real robot
#
# **The kick.** The derivative of the *error* jumps when the setpoint jumps, and the actuator gets a
# kick. The derivative of the *measurement* does not jump: a robot has mass. Between jumps both are
# the same, but for the sign.


# %%
def kicking(state, setpoint, measured, dt, gains, limits):
    """The same step with the derivative of the error: it sees the setpoint jump."""
    good = tracking.pid_step(state, setpoint, measured, dt, gains)
    before = state.proportional / gains.k_p + state.measured  # the setpoint of the last sample
    kick = gains.k_d * (setpoint - before) / dt if np.isfinite(before) else 0.0
    return good._replace(output=float(np.clip(good.output + kick, *limits[:2])))


gains, wide = PidGains(3.0, 2.0, 0.2), PidLimits(-30.0, 30.0)
runs = {"wrong: of the error": kicking, "reference": tracking.pid_step}
outputs = {name: turn_to(1.0, gains, wide, step=step)[1][:60] for name, step in runs.items()}
show(
    plots.plot_responses(time[:60], {"Output [m/s]": outputs}),
    f"The setpoint jumps at 0.2 s. With the derivative of the error the output goes to "
    f"{outputs['wrong: of the error'].max():.0f} m/s for one sample, with that of the measurement to "
    f"{outputs['reference'].max():.1f} m/s. The wheels can do 0.8.",
)

# %% [markdown]
# **Wind-up.** The output has limits. While it stands at one of them the error lasts, and the
# integral grows and grows. When the target is reached it must first be emptied: the robot goes far
# beyond. *Anti-windup*: while the output is at a limit, the integral must not push further.


# %%
def winding_up(state, setpoint, measured, dt, gains, limits):
    """The same step whose integral knows nothing of the limits."""
    free = tracking.pid_step(state, setpoint, measured, dt, gains)
    return free._replace(output=float(np.clip(free.output, *limits[:2])))


# %%
gains, narrow = PidGains(2.0, 3.0), PidLimits(-0.3, 0.3)
runs = {"wrong: winds up": winding_up, "reference": tracking.pid_step}
answers = {n: turn_to(np.pi, gains, narrow, step=s, seconds=8.0) for n, s in runs.items()}
turned = {name: np.degrees(heading) for name, (heading, _) in answers.items()}
outputs = {name: output for name, (_, output) in answers.items()}
panels, bounds = {title: turned, "Output [m/s]": outputs}, {"Output [m/s]": (-0.3, 0.3)}
most = {name: heading.max() for name, heading in turned.items()}
clock = 0.01 * np.arange(800)
show(
    plots.plot_responses(clock, panels, targets={title: 180.0}, limits=bounds),
    f"Half a turn with an output of at most 0.3 m/s. With a wound-up integral the cart turns to "
    f"{most['wrong: winds up']:.0f}°, with anti-windup to {most['reference']:.0f}°.",
)

# %% [markdown]
# **A sensor that says nothing.** `nan` in, `nan` out, and then for ever: `nan` is in the integral.
# A lost sample must change nothing but `rejected`, which counts such samples, and `gap`, the time
# without a measurement. The next derivative is spread over the whole gap.
#
# ### Exercise: one step (4 points)
#
# The state holds the terms of the last output, `proportional`, `integral`, `derivative`, all in
# units of the output; the last good measurement, `measured`, which is `nan` before the first; `gap`,
# `output` and `rejected`. It is a named tuple: `state._replace(gap=…)` makes a changed copy.
#
# Anti-windup in one sentence: if the output *before* it is cut is above the upper limit and this
# sample's share of the integral is positive, or below the lower and negative, the integral stays.


# %% exercise="tracking.pid_step"
def pid_step(state, setpoint, measured, dt, gains, limits):
    """One step of a PID controller; the new output stands in the new state.

    state : tracking.PidState
    setpoint, measured : float, in the same unit; measured may be nan
    dt : float [s]
    gains : tracking.PidGains(k_p, k_i, k_d); smoothing is 0
    limits : tracking.PidLimits(low, high); integral is inf
    returns : tracking.PidState
    """
    ### BEGIN SOLUTION
    error = setpoint - measured
    if not np.isfinite(error):
        return state._replace(gap=state.gap + dt, rejected=state.rejected + 1)
    proportional, growth, derivative = gains.k_p * error, gains.k_i * error * dt, 0.0
    if np.isfinite(state.measured):
        derivative = -gains.k_d * (measured - state.measured) / (dt + state.gap)
    output = proportional + state.integral + growth + derivative
    pushes = (output > limits.high and growth > 0) or (output < limits.low and growth < 0)
    integral = state.integral if pushes else state.integral + growth
    output = min(max(output, limits.low), limits.high)
    terms = proportional, integral, derivative
    return tracking.PidState(*terms, measured, 0.0, output, state.rejected)
    ### END SOLUTION


# %% check="tracking.pid_step"
pid_step = check("tracking.pid_step")

# %% [markdown]
# ### Play with the gains
#
# Your own step steers the cart with the soft tyre.
#
# **Task.** Leave $k_i$ and $k_d$ at 0. Raise $k_p$ until the cart is quick and swings a little. Raise $k_d$
# until it does not. Then $k_i$, until it ends on the line. Can you stay below 60° and be within 1°
# after one second?


# %%
def draw_gains(k_p, k_i, k_d):
    """The answer of the cart to a step of its heading, by your own controller."""
    heading, output = turn_to(1.0, PidGains(k_p, k_i, k_d), pull=0.5, step=pid_step)
    panels = {"Heading [deg]": {"mine": np.degrees(heading)}, "Output [m/s]": {"mine": output}}
    targets, limits = {"Heading [deg]": goal}, {"Output [m/s]": (-0.6, 0.6)}
    late = np.degrees(np.abs(heading[120:] - 1.0)).max()
    return plots.plot_responses(time, panels, targets=targets, limits=limits), (
        f"k_p {k_p:g}, k_i {k_i:g}, k_d {k_d:g}: up to {np.degrees(heading.max()):.0f}° for a target of 57°; "
        f"from one second after the step on within {late:.1f}°."
    )


explore(draw_gains, k_p=(0.0, 30.0, 0.5, 1.5), k_i=(0.0, 20.0, 0.5, 0.0), k_d=(0.0, 2.0, 0.05, 0.0))

# %% [markdown]
# ## 4. Which gains?
#
# The second method of Ziegler and Nichols: take P alone, and raise its gain until the loop swings
# without end. That gain $k_{cr}$ and the period $p_{cr}$ of the swing say how quick the loop can be:
#
# | kind | $k_p$ | $T_i$ | $T_d$ |
# |---|---|---|---|
# | P | $0.5\, k_{cr}$ | | |
# | PI | $0.45\, k_{cr}$ | $p_{cr} / 1.2$ | |
# | PID | $0.6\, k_{cr}$ | $p_{cr} / 2$ | $p_{cr} / 8$ |
#
# with $k_i = k_p / T_i$ and $k_d = k_p\, T_d$.
#
# ### Exercise: gains from an oscillation (1 point)


# %% exercise="tracking.ziegler_nichols"
def ziegler_nichols(k_cr, p_cr, kind):
    """Gains from the critical gain and period.

    k_cr : float [output / error]
    p_cr : float [s]
    kind : "P", "PI" or "PID"
    returns : tracking.PidGains(k_p, k_i, k_d)
    """
    ### BEGIN SOLUTION
    if kind == "P":
        return tracking.PidGains(0.5 * k_cr, 0.0, 0.0)
    if kind == "PI":
        return tracking.PidGains(0.45 * k_cr, 0.45 * k_cr / (p_cr / 1.2), 0.0)
    k_p = 0.6 * k_cr
    return tracking.PidGains(k_p, k_p / (p_cr / 2), k_p * p_cr / 8)
    ### END SOLUTION


# %% check="tracking.ziegler_nichols"
ziegler_nichols = check("tracking.ziegler_nichols")

# %% [markdown]
# **The numbers of a real robot.** A team in Surabaya built such a cart. It swung at $k_{cr} = 0.7$
# with a period of 21 samples of 10 ms. It counts time in milliseconds, we in seconds: the same
# controller, other numbers.

# %%
printed = {"k_p": 0.42, "k_i": 0.004, "k_d": 0.42 * 26.25}
in_ms, in_s = ziegler_nichols(0.7, 210.0, "PID"), ziegler_nichols(0.7, 0.21, "PID")
print("        printed   in ms      in s")
for name, value in printed.items():
    print(f"{name} {value:12.4f} {getattr(in_ms, name):9.4f} {getattr(in_s, name):9.4f}")

# %% [markdown]
# **Your own cart** has its own lag and wheel base. `world.swing(gain)` is the experiment. The cart
# drives ahead, 0.002 rad off its heading. A P controller steers: the right wheel is told to be faster by
# gain · error. You get the error, every 10 ms. It begins so small because wheels at their limit would
# tame the swing.

# %%
tried = {"gain 12": 12.0, "gain 21": 21.0, "gain 28": 28.0}
swings = {name: 1000 * world.swing(gain) for name, gain in tried.items()}
found = {name: tracking.find_oscillation(swing, 0.01) for name, swing in swings.items()}
panels = {f"{name}: error [mrad]": {name: swing} for name, swing in swings.items()}
growth = ", ".join(f"{one.growth:.2f} with {name}" for name, one in found.items())
show(
    plots.plot_responses(0.01 * np.arange(250), panels),
    f"Heading error of your own cart. From one swing to the next its size is multiplied by {growth}.",
)

# %% [markdown]
# ### Your numbers: critical gain and period (1 point each)
#
# At which gain does your cart swing without end, in m/s per rad, and with which period, in s?
# `tracking.find_oscillation(error, 0.01)` gives `period` and `growth`. At the critical gain the growth
# is 1.

# %% answer="tracking.own_gain"
answer(
    "tracking.own_gain",
    ### BEGIN SOLUTION
    tracking.critical_gain(world.swing, 2.0, 0.01).gain,
    ### END SOLUTION
)

# %% answer="tracking.own_period"
answer(
    "tracking.own_period",
    ### BEGIN SOLUTION
    tracking.critical_gain(world.swing, 2.0, 0.01).period,
    ### END SOLUTION
)

# %% [markdown]
# The rules are a place to begin. Their authors wanted disturbances to fade quickly, and put up with
# an overshoot. Here are the gains for the cart of section 3, and the same with $k_i$ cut to a tenth. Its
# lag is chosen so that it swings like the cart from Surabaya.

# %%
ours = worlds.PracticeWorld(tracking.DifferentialModel())
critical = tracking.critical_gain(ours.swing, 2.0, 0.01)
rule = ziegler_nichols(*critical, "PID")
trial_gains = {"Ziegler-Nichols": rule, "k_i a tenth": rule._replace(k_i=rule.k_i / 10)}
answers = {name: turn_to(0.2, g, step=pid_step)[0][:150] for name, g in trial_gains.items()}
headings = {name: np.degrees(heading) for name, heading in answers.items()}
over = [100 * (heading.max() / 0.2 - 1) for heading in answers.values()]
target = np.degrees(np.where(time[:150] < 0.2, 0.0, 0.2))
show(
    plots.plot_responses(time[:150], {title: headings}, targets={title: target}),
    f"The cart swings without end at a gain of {critical.gain:.1f} m/s per rad, with a period of {100 * critical.period:.1f} samples; "
    f"the one from Surabaya with 21. A step of 11° with the rule's gains, k_p {rule.k_p:.1f}, k_i {rule.k_i:.0f}, "
    f"k_d {rule.k_d:.2f}, overshoots by {over[0]:.0f} %, with a tenth of k_i by {over[1]:.0f} %.",
)

# %% [markdown]
# ## 5. Where on the path am I?
#
# A path is a row of points with straight lines between them. The nearest point is in general *on* a
# line, not one of the points. On the segment from $a$ along $d$, for a robot at $p$:
#
# $$s = \frac{(p - a) \cdot d}{d \cdot d}, \quad \text{cut to } 0 \le s \le 1,
# \qquad \text{nearest point} = a + s\, d$$
#
# **Not the nearest of all.** A path may come back on itself. Then the nearest point of the whole path
# may lie on another leg, and the robot takes a short cut through everything. So the search begins at
# the segment of last time. It gives up when a segment *ends* more than `reach` farther along the path
# than the nearest point so far. A segment that is begun is searched whole.

# %%
hairpin = worlds.finely([[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]], 0.05)
place = np.array([0.8, 0.3])
whole = tracking.nearest_point(hairpin, place)
near = tracking.nearest_point(hairpin, place, 10, 0.4)

# %%
fig, ax = figure(7.6, 2.3)
ax.plot(*hairpin.T, "-", color=plots.TRUTH, alpha=0.3, linewidth=5)
for one, paint, words in (
    (whole, plots.WARN, "whole path"),
    (near, plots.REFERENCE, "from here on"),
):
    ax.plot(*np.stack([place, one.xy]).T, "--", color=paint)
    ax.plot(*one.xy, "o", color=paint, label=words, markersize=8)
ax.plot(*place, "o", color=plots.MINE, markersize=9, label="robot, on the way out")
ax.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
show(
    fig,
    f"A way out and back, 0.5 m apart. The nearest point of the whole path is on segment {whole.index} of the "
    f"way back, {100 * whole.distance:.0f} cm off; searched from here on it is on segment {near.index}, {100 * near.distance:.0f} cm off.",
)

# %% [markdown]
# ### Exercise: the nearest point (3 points)
#
# Of two that are as near the first counts: take a new one only if it is nearer by more than $10^{-9}$ m.
# A segment of length 0 (a point drawn twice) has share 0.


# %% exercise="tracking.nearest_point"
def nearest_point(path, point, start_index, reach):
    """The nearest point of a path, searched from a segment on.

    path : (n, 2) array [m, map]
    point : (2,) array [m, map]
    start_index : int, the first segment; segment k goes from path[k] to path[k + 1]
    reach : float [m], give up after so much of the path past the nearest point so far
    returns : tracking.PathPoint(index, share, xy=(x, y), distance)
    """
    ### BEGIN SOLUTION
    best, walked = None, 0.0
    for k in range(start_index, len(path) - 1):
        way = path[k + 1] - path[k]
        length = np.hypot(*way)
        share = np.clip((point - path[k]) @ way / length**2, 0.0, 1.0) if length else 0.0
        xy = path[k] + share * way
        distance = np.hypot(*(point - xy))
        walked += length
        if best is None or distance < best.distance - 1e-9:
            best, walked = tracking.PathPoint(k, share, tuple(xy), distance), (1 - share) * length
        if walked > reach:
            break
    return best
    ### END SOLUTION


# %% check="tracking.nearest_point"
nearest_point = check("tracking.nearest_point")

# %% [markdown]
# ## 6. Which point do I look at?
#
# The **look-ahead point**: the first point of the path, from the nearest one on, that is `lookahead`
# away from the robot. A circle around the robot meets the path there. On a segment from $a$ along
# $d$ that is
#
# $$|a + s\,d - p| = L \quad\Rightarrow\quad s = \frac{-B + \sqrt{B^2 - AC}}{A}, \qquad
# A = d \cdot d,\; B = (a - p) \cdot d,\; C = |a - p|^2 - L^2$$
#
# The other root lies behind. Two exceptions: if the starting point is as far away already, it is the
# answer. If no point is so far away, the end of the path is.
#
# ### Exercise: the look-ahead point (2 points)


# %% exercise="tracking.lookahead_point"
def lookahead_point(path, point, lookahead, index, share):
    """The first point of a path that is so far away, searched from a point of it on.

    path : (n, 2) array [m, map]
    point : (2,) array, the robot's place [m, map]
    lookahead : float [m], straight from there
    index, share : int and float, where the search begins, as nearest_point gives them
    returns : tracking.PathPoint(index, share, xy=(x, y), distance)
    """
    ### BEGIN SOLUTION
    last = len(path) - 2
    for k in range(index, last + 1):
        a, d = path[k], path[k + 1] - path[k]
        s = share if k == index else 0.0
        if np.hypot(*(a + s * d - point)) >= lookahead:
            break
        if np.hypot(*(a + d - point)) >= lookahead:
            A, B, C = d @ d, (a - point) @ d, (a - point) @ (a - point) - lookahead**2
            s = (-B + np.sqrt(B * B - A * C)) / A
            break
    else:
        k, s = last, 1.0
    xy = path[k] + s * (path[k + 1] - path[k])
    return tracking.PathPoint(k, s, tuple(xy), np.hypot(*(xy - point)))
    ### END SOLUTION


# %% check="tracking.lookahead_point"
lookahead_point = check("tracking.lookahead_point")

# %% [markdown]
# ## 7. Pure pursuit
#
# There is one circle that touches the robot's heading and leads through the look-ahead point. Drive
# it for 10 ms, then look again.
#
# The robot stands at 0 and faces along x; the point is $a$ ahead and $b$ to the left. The circle's
# middle is $r$ to the left. Both lie on it: $a^2 + (b - r)^2 = r^2$. So
#
# $$\kappa = \frac{1}{r} = \frac{2\,b}{a^2 + b^2}, \qquad \omega = v\,\kappa$$
#
# | symbol | meaning | unit, frame |
# |---|---|---|
# | $L$ `lookahead` | distance to the look-ahead point | m |
# | $a, b$ | that point: ahead, to the left | m, base |
# | $\kappa$ `curvature` | of the circle, left positive | 1/m |
# | $v, \omega$ | speed, turn rate | m/s, rad/s |

# %%
bow = np.array([[0.0, 0.0], [0.5, 0.05], [0.9, 0.2], [1.3, 0.3], [1.8, 0.3]])
pose = np.array([0.35, -0.22, -0.1])
aim = tracking.pure_pursuit(bow, pose, 0.7)
foot = tracking.nearest_point(bow, pose[:2])
show(
    plots.plot_pursuit(bow, pose, aim.target, aim.curvature, foot.xy),
    f"The robot is {100 * foot.distance:.0f} cm to the right of its path and looks 0.70 m ahead. The circle that "
    f"touches its heading and leads to that point has a radius of {1 / aim.curvature:.2f} m, to the left.",
)

# %% [markdown]
# ### Exercise: pure pursuit (3 points)
#
# Build it on your own two functions: `nearest_point` with `reach = lookahead`, then
# `lookahead_point` from there on. `index` is the segment of the *nearest* point: the next call starts
# there. `done` is true if all three hold:
#
# - the target is the end of the path,
# - along the path no more than `tracking.TOLERANCE`, 1 cm, is left from the nearest point on,
# - the nearest point is nearer than the look-ahead.


# %% exercise="tracking.pure_pursuit"
def pure_pursuit(path, pose, lookahead, start_index):
    """The circle that leads to the path a little ahead.

    path : (n, 2) array [m, map]
    pose : (3,) array (x, y, theta) [m, m, rad; map]
    lookahead : float [m]
    start_index : int, the segment from which the search begins
    returns : tracking.Pursuit(curvature [1/m], target=(x, y), index, done)
    """
    ### BEGIN SOLUTION
    place, theta = np.array(pose[:2]), pose[2]
    foot = nearest_point(path, place, start_index, lookahead)
    target = lookahead_point(path, place, lookahead, foot.index, foot.share)
    dx, dy = np.array(target.xy) - place
    left, square = np.cos(theta) * dy - np.sin(theta) * dx, dx**2 + dy**2
    curvature = 2 * left / square if square > 0 else 0.0
    rest = np.vstack([foot.xy, path[foot.index + 1 :]])
    remains = np.hypot(*np.diff(rest, axis=0).T).sum()
    at_end = target.index == len(path) - 2 and target.share > 1 - 1e-9
    done = at_end and remains <= tracking.TOLERANCE and foot.distance < lookahead
    return tracking.Pursuit(curvature, target.xy, foot.index, bool(done))
    ### END SOLUTION


# %% check="tracking.pure_pursuit"
pure_pursuit = check("tracking.pure_pursuit")

# %% [markdown]
# ### How far ahead?
#
# $$L = k\,v + L_{\text{least}}$$
#
# Farther at speed, because wheels are late: what you order now happens while you drive on.
# `tracking.TrackingSettings` holds `k` and `least`, the `speed` on straights, and the `lateral`
# acceleration allowed in bends. The whole loop, on your own pursuit:


# %%
def follow(path, settings, model=None):
    """Drive a path with your own parts: true poses, shape (n, 3)."""
    speeds = tracking.speed_profile(path, settings.speed, tracking.ACCEL, settings.lateral)
    cart = Cart(model or tracking.DifferentialModel(), tracking.start_pose(path))
    poses, index, every = [cart.state.pose], 0, np.arange(len(path))
    while len(poses) < 5000:
        here = nearest_point(path, cart.pose[:2], index, tracking.REACH)
        v = max(np.sqrt(np.interp(here.index + here.share, every, speeds**2)), tracking.CREEP)
        found = pure_pursuit(path, cart.pose, settings.k * v + settings.least, here.index)
        index = found.index
        if found.done:
            break
        cart.drive(v, v * found.curvature)
        poses.append(cart.state.pose)
    return np.array(poses)


# %% [markdown]
# `tracking.trial` is the same loop, compiled: fast enough for sliders, and for searches with
# hundreds of drives. Its first call takes some seconds, once on this computer.

# %%
SOURCE = {name: worlds.finely(path) for name, path in worlds.SOURCE_PATHS.items()}
settings = TrackingSettings(k=0.1, least=0.05, speed=0.38, lateral=0.3)
own = follow(SOURCE["roof"], settings)
run = tracking.trial(SOURCE["roof"], settings=settings)
apart = np.abs(own - run.poses[: len(own)]).max()
print(f"{len(own)} poses; yours and the compiled loop's differ by less than {1e-6 + apart:.0e} m.")

# %% [markdown]
# ### Play with the look-ahead
#
# **Task.** At which look-ahead does the cart begin to swing? How does that change with the lag of
# the wheels? What does a long look-ahead do to the corners?


# %%
def draw_lookahead(k, least, lag):
    """A zigzag with sharp corners, by the cart with these look-aheads."""
    settings = TrackingSettings(k, least, speed=0.38, lateral=0.6)
    run = tracking.trial(SOURCE["zigzag"], tracking.DifferentialModel(lag=lag), settings)
    end = f"it arrives after {run.duration:.1f} s" if run.done else "it never arrives"
    return plots.plot_path_errors(SOURCE["zigzag"], {"reference": run}), (
        f"Look-ahead {k:g} s times speed plus {least:g} m, wheels with a lag of {lag:g} s: at most "
        f"{100 * run.worst:.1f} cm off the path; {end}."
    )


explore(
    draw_lookahead,
    k=(0.0, 1.0, 0.05, 0.1),
    least=(0.01, 0.5, 0.01, 0.05),
    lag=(0.02, 0.3, 0.01, 0.07),
)

# %% [markdown]
# **Too long.** The cart aims past the corner long before it is there, and cuts it.

# %%
runs = {
    name: tracking.trial(
        SOURCE["zigzag"],
        settings=TrackingSettings(0.0, least, 0.38, 0.6),
        faults=Faults(noise=0.001),
    )
    for name, least in {"5 cm": 0.05, "wrong: 40 cm": 0.40, "1 cm": 0.01}.items()
}
shaking = runs.pop("1 cm")
show(
    plots.plot_path_errors(SOURCE["zigzag"], runs),
    f"Look-ahead 5 cm: at most {100 * runs['5 cm'].worst:.1f} cm off. Look-ahead 40 cm: "
    f"{100 * runs['wrong: 40 cm'].worst:.1f} cm, at the corners.",
)

# %% [markdown]
# **Too short.** A hair's breadth beside the path is a sharp bend already. The cart turns as hard as it
# can, to the left, to the right: its wheels are late, and it has turned too far before they follow. It stays
# on the path and shakes, and the turning leaves no speed for the way.

# %%
first = 300
rates = {
    name: np.gradient(np.unwrap(run.poses[:first, 2]), 0.01)
    for name, run in {"wrong: 1 cm": shaking, "5 cm": runs["5 cm"]}.items()
}
show(
    plots.plot_responses(0.01 * np.arange(first), {"Turn rate on a straight line [rad/s]": rates}),
    f"Look-ahead 1 cm: the cart shakes with {np.sqrt(np.mean(rates['wrong: 1 cm'] ** 2)):.1f} rad/s, RMS, and "
    f"{'arrives' if shaking.done else 'gives up'} after {shaking.time[-1]:.0f} s. With 5 cm it drives straight, and arrives after {runs['5 cm'].duration:.0f} s.",
)

# %% [markdown]
# ## 8. As fast as bends and brakes allow
#
# In a bend of curvature $\kappa$ the robot is pushed outwards with $v^2 |\kappa|$. The floor holds so
# much and no more. And nobody brakes in no time: over a way $\Delta s$ the square of the speed changes
# by $2 a \Delta s$ at most.
#
# $$v^2 \le \frac{a_{\text{lat}}}{|\kappa|}, \qquad v_{k+1}^2 \le v_k^2 + 2\,a\,\Delta s,
# \qquad v_k^2 \le v_{k+1}^2 + 2\,a\,\Delta s$$
#
# Three steps: the limits of bends, and 0 at both ends. Then forwards from the start, so that no
# speed is more than the one before allows. Then backwards from the end, so that it brakes in time.
#
# ### Exercise: the speed profile (3 points)
#
# `tracking.path_curvature(path)` gives $\kappa$ at each point, left positive.


# %% exercise="tracking.speed_profile"
def speed_profile(path, max_speed, max_accel, max_lateral_accel):
    """The greatest speed at each point that keeps within all limits, from rest to rest.

    path : (n, 2) array [m, map]
    max_speed : float [m/s]
    max_accel : float [m/s^2], along the path, forwards and braking
    max_lateral_accel : float [m/s^2], across it
    returns : (n,) array [m/s]
    """
    ### BEGIN SOLUTION
    steps = np.hypot(*np.diff(path, axis=0).T)
    bend = np.maximum(np.abs(tracking.path_curvature(path)), 1e-12)
    v = np.minimum(max_speed, np.sqrt(max_lateral_accel / bend))
    v[0] = v[-1] = 0.0
    for k in range(1, len(v)):
        v[k] = min(v[k], np.sqrt(v[k - 1] ** 2 + 2 * max_accel * steps[k - 1]))
    for k in range(len(v) - 2, -1, -1):
        v[k] = min(v[k], np.sqrt(v[k + 1] ** 2 + 2 * max_accel * steps[k]))
    return v
    ### END SOLUTION


# %% check="tracking.speed_profile"
speed_profile = check("tracking.speed_profile")

# %%
bends = np.sqrt(2.0 / np.maximum(np.abs(tracking.path_curvature(eight)), 1e-9))
speeds = np.asarray(speed_profile(eight, 2.0, 2.0, 2.0))
slow = geometry.distance_along(eight)[-1] / speeds[20:-20].min()
takes = tracking.profile_times(eight, tracking.speed_profile(eight, 2.0, 2.0, 2.0))[-1]
show(
    plots.plot_speeds(eight, speeds, {"limit of the bends": np.minimum(bends, 9.0)}),
    f"Speed along the eight of section 2: {speeds.max():.1f} m/s at most, down to {speeds[20:-20].min():.2f} m/s in the "
    f"bends. It takes {takes:.1f} s; at the bends' speed all the way it would be {slow:.1f} s.",
)

# %% [markdown]
# Is it worth it? The cart on a path with two corners: at 0.35 m/s all the way, and at up to 0.7 m/s with a
# profile.

# %%
even = tracking.trial(SOURCE["square"], settings=TrackingSettings(0.1, 0.05, 0.35, 50.0))
bent = tracking.trial(SOURCE["square"], settings=TrackingSettings(0.1, 0.05, 0.70, 0.3))
show(
    plots.plot_path_errors(
        SOURCE["square"], {"wrong: one speed": even, "reference: profile": bent}
    ),
    f"At one speed: {even.duration:.1f} s and up to {100 * even.worst:.1f} cm off. With a profile: "
    f"{bent.duration:.1f} s and {100 * bent.worst:.1f} cm. Faster, and closer to the path.",
)

# %% [markdown]
# ## 9. Three paths from Surabaya
#
# The paper with the cart of section 4 lets it drive three paths, at 0.25 and at 0.38 m/s, towards one
# waypoint after the other. A PID controller turns it to the bearing of the next one. Published: within
# 10 cm in x; in y within 14 cm and 7 cm at the slow speed, 10 and 7 cm at the fast one; the end
# within 3 cm.
#
# Here is that scheme with your own controller, beside pursuit with a speed profile, on our cart.


# %%
MOST = PidLimits(-1.2, 1.2)


def by_bearing(waypoints, speed, bearing_of=np.arctan2, seconds=30.0):
    """Turn to the bearing of one waypoint after the other, at constant speed: true poses."""
    cart, state, poses, k = Cart(pose=(0.0, 0.0, np.pi / 2)), PidState(), [], 1
    while k < len(waypoints) and len(poses) < 100 * seconds:
        x, y, theta = cart.pose
        dx, dy = np.array(waypoints[k]) - (x, y)
        error = geometry.wrap_angle(bearing_of(dy, dx) - theta)
        state = pid_step(state, theta + error, theta, 0.01, rule, MOST)
        cart.drive(speed, state.output / cart.model.wheel_base)
        poses.append(cart.state.pose)
        k += np.hypot(dx, dy) < 0.05
    for _ in range(60):
        cart.drive(0.0, 0.0)
    return np.array([*poses, cart.state.pose])


# %%
def pursue(name, speed):
    """The same path by pursuit with a speed profile."""
    return tracking.trial(SOURCE[name], settings=TrackingSettings(0.1, 0.05, speed, 0.3))


def widest(name, poses):
    """Farthest left, right, below and above the path [m], one after the other along it."""
    off = poses[:, :2] - tracking.nearest_points(SOURCE[name], poses).xy
    return off.min(axis=0), off.max(axis=0)


# %%
driven = {
    name: {
        "to the waypoints": by_bearing(corners, 0.38),
        "reference: pursuit": pursue(name, 0.38).poses,
    }
    for name, corners in worlds.SOURCE_PATHS.items()
}
far = {
    name: [np.abs(widest(name, p)).max() for p in both.values()] for name, both in driven.items()
}
words = "; ".join(f"{name}: {100 * a:.1f} and {100 * b:.1f} cm" for name, (a, b) in far.items())
show(
    plots.plot_source_paths(worlds.SOURCE_PATHS, driven),
    f"Three test paths at 0.38 m/s. Largest deviation to the waypoints and by pursuit, {words}.",
)

# %% [markdown]
# All six runs beside the published bands. The bands come from a real robot on a real floor, so they
# hold what our simulation lacks: slip, and a wheel base that nobody knows exactly. Compare the two
# schemes with each other first.

# %%
rows, ends = {}, {}
for speed, bands in worlds.PUBLISHED.items():
    ways = {"to waypoints": [], "pursuit": []}
    for name, corners in worlds.SOURCE_PATHS.items():
        ways["to waypoints"].append((name, by_bearing(corners, speed)))
        ways["pursuit"].append((name, pursue(name, speed).poses))
    rows[speed, "published"] = np.transpose(bands)
    for scheme, runs in ways.items():
        lows, highs = np.transpose([widest(*run) for run in runs], (1, 0, 2))
        rows[speed, scheme] = lows.min(axis=0), highs.max(axis=0)
        ends[speed, scheme] = max(np.hypot(*(p[-1, :2] - SOURCE[n][-1])) for n, p in runs)

# %%
for (speed, scheme), band in rows.items():
    (x0, y0), (x1, y1) = 100 * np.array(band)
    end = 100 * ends.get((speed, scheme), 0.03)
    print(
        f"{speed} m/s {scheme:12s} x {x0:+5.1f} to {x1:+5.1f}, y {y0:+5.1f} to {y1:+5.1f}, end {end:.1f} cm"
    )

# %%
fig, panels = figure(8.2, 3.0, columns=2, sharey=True)
paint = {"published": "0.75", "to waypoints": plots.MINE, "pursuit": plots.REFERENCE}
for ax, axis in zip(panels, (0, 1)):
    for row, ((speed, scheme), (low, high)) in enumerate(rows.items()):
        width = 100 * (high[axis] - low[axis])
        ax.barh(-row - row // 3, width, 0.75, 100 * low[axis], color=paint[scheme])
    ax.axvline(0.0, color=plots.TRUTH, linewidth=1.0)
    ax.set(title=f"off the path in {'xy'[axis]} [cm]", xlim=(-16, 16))
    ax.grid(axis="y", visible=False)
names = [f"{speed} m/s, {scheme}" for speed, scheme in rows]
panels[0].set_yticks([-row - row // 3 for row in range(6)], names)

# %%
most = 100 * max(np.abs(rows[s, "pursuit"]).max() for s in worlds.PUBLISHED)
last = 1000 * max(ends[s, "pursuit"] for s in worlds.PUBLISHED)
show(
    fig,
    f"Bands of deviation by speed and scheme. Published up to 14 cm; pursuit on our cart stays within "
    f"{most:.1f} cm and ends within {last:.0f} mm.",
)

# %% [markdown]
# ## 10. The other way to write it
#
# The *incremental* form adds a change to the last output instead of making it anew:
#
# $$u \leftarrow u + k_p\,\Delta e + k_i\, e\,\Delta t - k_d\,\Delta \dot y$$
#
# It cannot wind up: what a limit cuts off is never remembered. And it takes over from any output
# without a jump. Between the limits both forms are the same. The figure: a wheel with a lag of 0.1 s. Until
# t = 0.5 s somebody drives by hand; then each form takes over and brings the speed to 0.8 m/s.


# %%
def take_over(pid, ready):
    """Speed of a wheel and the order to it; by hand at first, then by a controller."""
    speed, rows = 0.5, []
    for k in range(200):
        if k == 50:
            ready(pid, speed)
        order = pid.update(0.8, speed, 0.01) if k >= 50 else 0.5
        speed += (order - speed) * (1 - np.exp(-0.01 / 0.1))
        rows.append((speed, order))
    return np.array(rows).T


# %%
gains, bound = PidGains(0.5, 5.0), PidLimits(-1.0, 1.0)
forms = {
    "position": take_over(tracking.Pid(gains, bound), lambda pid, speed: None),
    "incremental": take_over(
        tracking.IncrementalPid(gains, bound), lambda pid, speed: pid.take_over(0.5, 0.8 - speed)
    ),
}
panels = {"Speed [m/s]": {}, "Order [m/s]": {}}
for name, (speed, order) in forms.items():
    panels["Speed [m/s]"][name], panels["Order [m/s]"][name] = speed, order
low = {name: order[50] for name, (_, order) in forms.items()}
show(
    plots.plot_responses(0.01 * np.arange(200), panels, targets={"Speed [m/s]": 0.8}),
    f"Taking over at 0.5 m/s. The position form begins with an order of {low['position']:.2f} m/s, the "
    f"incremental one with {low['incremental']:.2f} m/s.",
)

# %% [markdown]
# ## 11. Break it
#
# The zigzag once more, one failure at a time. The pose may be late (`delay`), lost in some samples
# (`dropped`, the last order holds), or noisy.

# %%
good = TrackingSettings(0.1, 0.05, 0.38, 0.6)
blame = {
    "all in order": (good, Faults()),
    "look-ahead 1 cm": (good._replace(k=0.0, least=0.01), Faults()),
    "look-ahead 40 cm": (good._replace(k=0.0, least=0.4), Faults()),
    "pose 0.1 s late": (good, Faults(delay=0.1)),
    "the same, looking 0.3 s ahead": (good._replace(k=0.3), Faults(delay=0.1)),
    "half the samples lost": (good, Faults(dropped=0.5)),
    "9 of 10 samples lost": (good, Faults(dropped=0.9)),
    "noise of 1 cm": (good, Faults(noise=0.01)),
    "no braking for corners": (good._replace(lateral=50.0), Faults()),
}
broken = {n: tracking.trial(SOURCE["zigzag"], settings=s, faults=f) for n, (s, f) in blame.items()}

# %%
names = list(broken)[::-1]
runs = [broken[name] for name in names]
columns = {
    "at most [cm]": ([100 * run.worst for run in runs], 2.9),
    "RMS [cm]": ([100 * np.sqrt(np.mean(run.cross_track**2)) for run in runs], 0.6),
    "it takes [s]": ([run.time[-1] for run in runs], 20.0),
}

# %%
fig, panels = figure(8.2, 3.8, columns=3, sharey=True)
for ax, (words, (values, limit)) in zip(panels, columns.items()):
    values = np.array(values)
    ax.scatter(values, names, s=50, color=np.where(values > limit, plots.WARN, plots.REFERENCE))
    ax.set(title=words, xscale="log", xlim=(values.min() / 1.6, values.max() * 6))
    for row, value in enumerate(values):
        ax.annotate(f"{value:.1f}", (value, row), (7, 0), textcoords="offset points", va="center")
most, typical, _ = (dict(zip(names, values)) for values, _ in columns.values())
show(
    fig,
    f"Nine runs on the zigzag. In order the cart is {typical['all in order']:.1f} cm off the path, RMS; with a "
    f"look-ahead of 40 cm {typical['look-ahead 40 cm']:.1f} cm, with a pose 0.1 s late {typical['pose 0.1 s late']:.1f} cm, "
    f"with half its samples lost {typical['half the samples lost']:.1f} cm.",
)

# %% [markdown]
# **Lost samples** cost little, as long as some come: the last order holds. With one in ten left it holds
# for 0.1 s on average, and the cart begins to swing, as with a late pose.
#
# **A late pose** acts like a longer lag: the cart swings. Look farther ahead, and it calms down; the
# corners pay for it.

# %%
pair = {"wrong: pose 0.1 s late": broken["pose 0.1 s late"]}
pair["reference: looks farther ahead"] = broken["the same, looking 0.3 s ahead"]
calm = [100 * np.sqrt(np.mean(run.cross_track**2)) for run in pair.values()]
show(
    plots.plot_path_errors(SOURCE["zigzag"], pair),
    f"With a pose 0.1 s late the cart swings, RMS {calm[0]:.1f} cm. With k = 0.3 s instead of 0.1 s "
    f"{calm[1]:.1f} cm.",
)

# %% [markdown]
# **A hairpin.** A search of the whole path finds the leg that is nearer, not the one the robot is on.
# A wrong pose for a moment is enough, and a piece of the path is left out. Here the legs are 12 cm
# apart.


# %%
narrow_turn = worlds.finely([[0.0, 0.0], [1.6, 0.0], [1.6, 0.12], [0.0, 0.12]], 0.02)


def along_hairpin(search):
    """Drive the hairpin with a nudge of 8 cm on the way: true places."""
    cart, places, index = Cart(), [], 0
    for k in range(1600):
        pose = cart.pose + (np.array([0.0, 0.08, 0.0]) if 120 <= k < 160 else 0.0)
        foot = search(pose[:2], index)
        found = tracking.pure_pursuit(narrow_turn, pose, 0.1, foot.index)
        index = found.index
        if found.done:
            break
        cart.drive(0.25, 0.25 * np.clip(found.curvature, -12, 12))
        places.append(cart.state.pose)
    return np.array(places)


# %%
nudged = {
    "wrong: whole path": along_hairpin(lambda p, k: tracking.nearest_point(narrow_turn, p)),
    "reference: from here on": along_hairpin(
        lambda p, k: tracking.nearest_point(narrow_turn, p, k, 0.1)
    ),
}
reached = [path[:, 0].max() for path in nudged.values()]
show(
    plots.plot_paths(nudged, markers={"start": (0.0, 0.0)}),
    f"A hairpin with its turn at x = 1.60 m. For 0.4 s the pose is 8 cm off. With a search of the whole path "
    f"the cart gets no farther than x = {reached[0]:.2f} m; searching from here on it drives all of it, to {reached[1]:.2f} m.",
)

# %% [markdown]
# ## 12. Check the source
#
# **The pursuit of the thesis.** Its listing goes from waypoint to waypoint and aims at one of them.
# Two of its conditions compare with the last waypoint but one. So the last is never chosen, and past
# the last but one the inner loop never ends.


# %%
def printed_target(path, x, reach, index, most=1000):
    """Where the listing aims on a straight path; None: its loop never ends."""
    here = abs(path[index] - x)
    for _ in range(most):
        following = abs(path[index + 1] - x)
        if here < following:
            break
        index += index + 1 < len(path) - 1
        here = following
    else:
        return None
    while reach > abs(path[index] - x) and index + 1 < len(path) - 1:
        index += 1
    return path[index]


# %%
waypoints, places = np.arange(0.0, 2.01, 0.25), np.arange(0.0, 1.995, 0.01)
aims = [printed_target(waypoints, x, 0.4, 0) for x in places]
straight = np.column_stack([waypoints, 0.0 * waypoints])
ours = [tracking.pure_pursuit(straight, [x, 0.0, 0.0], 0.4).target[0] for x in places]
stuck = places[aims.index(None)]

# %%
fig, ax = figure(7.0, 3.0)
ax.plot(places, ours, color=plots.REFERENCE, linewidth=2.4, label="ours")
ax.plot(places, np.array(aims, float), color=plots.WARN, label="as printed")
ax.axvspan(stuck, 2.0, color=plots.WARN, alpha=0.15, linewidth=0)
ax.annotate("its loop\nnever ends ", (stuck, 0.6), color=plots.WARN, ha="right")
ax.set(xlabel="robot at x [m]", ylabel="it aims at x [m]", xlim=(0, 2))
ax.legend()
show(
    fig,
    f"Waypoints every 25 cm up to 2 m, look-ahead 0.4 m. As printed the target jumps by 25 cm, goes no farther than "
    f"{np.nanmax(np.array(aims, float)):.2f} m, and from x = {stuck:.2f} m on the search never ends. Ours moves smoothly to 2 m.",
)

# %% [markdown]
# The thesis also says that a robot that is faster steers more aggressively, since $L$ grows with $v$.
# It is the other way round. 10 cm beside a straight path:

# %%
line = np.array([[0.0, 0.0], [5.0, 0.0]])
for v in (0.0, 1.0, 2.0):
    far_ahead = float(tracking.lookahead_distance(v, k=0.3, least=0.2))
    bend = abs(tracking.pure_pursuit(line, [0.5, 0.1, 0.0], far_ahead).curvature)
    print(f"{v:.0f} m/s: look-ahead {far_ahead:.1f} m, curvature {bend:.2f} 1/m")

# %% [markdown]
# **Its speed controller** adds the derivative of the measurement, where it has to be subtracted. A
# mass that is pulled to 0 shows what that does.


# %%
def pulled(k_d):
    """A mass of 1 kg, 10 cm from where it should be, pulled there by P and D."""
    place, speed, state, places = 0.1, 0.0, PidState(), []
    for _ in range(300):
        state = tracking.pid_step(state, 0.0, place, 0.01, PidGains(25.0, 0.0, k_d))
        speed += 0.01 * state.output
        place += 0.01 * speed
        places.append(100 * place)
    return np.array(places)


signs = {"wrong: derivative added": pulled(-1.0), "reference": pulled(4.0)}
size = [np.abs(places[-60:]).max() for places in signs.values()]
show(
    plots.plot_responses(0.01 * np.arange(300), {"Place [cm]": signs}, targets={"Place [cm]": 0.0}),
    f"A mass 10 cm from its place. With the derivative added it swings up to {size[0]:.0f} cm within 3 s; "
    f"subtracted it comes to rest, {size[1]:.2f} cm off.",
)

# %% [markdown]
# **The position of the paper** is $x = d \sin\theta$, $y = d \cos\theta$ with the *whole* distance $d$
# driven so far. That holds on a straight line from the start, and nowhere else: at the first corner
# the robot seems to leap. It has to be summed step by step.

# %%
truth = pursue("square", 0.38).poses
way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(truth[:, :2], axis=0).T))])
printed_way = way[:, None] * np.column_stack([np.cos(truth[:, 2]), np.sin(truth[:, 2])])
until = np.argmax(way > 2.9)
leap = np.hypot(*(printed_way[until] - truth[until, :2]))
show(
    plots.plot_paths({"truth": truth[:until], "wrong: as printed": printed_way[:until]}),
    f"The first two legs of the square. By the printed formula the robot is {leap:.2f} m from where it is.",
)

# %% [markdown]
# **Its bearing** is $\arctan(\Delta y / \Delta x)$: half of all directions come out as their opposites. The
# zigzag begins straight ahead, along y. A hair's breadth to the right of it, $\Delta x$ is negative, and
# the next waypoint seems to lie behind.


# %%
def printed_bearing(dy, dx):
    """Equation 11: the arctangent of a quotient."""
    return np.arctan(dy / dx) if dx else np.pi / 2


lost = by_bearing(worlds.SOURCE_PATHS["zigzag"], 0.25, printed_bearing, seconds=6.0)
away = np.hypot(*(lost[-1, :2] - (0.0, 1.5)))
show(
    plots.plot_paths(
        {"wrong: arctan": lost, "truth: path": SOURCE["zigzag"]}, markers={"first": (0.0, 1.5)}
    ),
    f"With the printed bearing the cart turns round at the start and drives away; after 6 s it is {away:.1f} m "
    "from its first waypoint.",
)

# %% [markdown]
# More that does not hold in print:
#
# | where | printed | what it does |
# |---|---|---|
# | thesis, Compute | integral cut to output / $k_i$, derivative to output / $k_d$ | divides by zero for P, PI and PD controllers |
# | thesis, Compute | returns only when a sample is due | between samples it returns nothing, and the sum fails |
# | thesis, Control | speed += output of a position form | P acts as an integral: it overshoots |
# | thesis, Control | clamp 100 to 1000 mm/s | told to stand still, it rolls at 100 mm/s |
# | thesis, Compute | integral = 0 where the error changes sign | against a steady pull it never comes to rest |
# | paper (4), (11), (12) | heading from the y axis clockwise, bearing from the x axis | a robot on course seems 90° off |
# | paper, $K_i = 0.004$ | per millisecond | 4 per second |

# %% [markdown]
# ## 13. How a swerve robot uses it
#
# Pursuit steers a cart. A swerve robot has no steering: it drives where it is told, and looks where it
# likes. But it has a direction of travel, the **course** $\psi$, and that can be steered. The robot's
# law has four lines:
#
# $$\dot\psi = v\,\kappa, \qquad
# \dot x = v \cos\psi - u\,\sin\psi, \qquad
# \dot y = v \sin\psi + u\,\cos\psi, \qquad
# \omega = w$$
#
# - $v$: the speed profile, a little ahead of the nearest point: motors lag.
# - $\kappa$: pure pursuit from the pose $(x, y, \psi)$, with $L = 0.1\,\mathrm{s} \cdot v + 0.1\,\mathrm{m}$. The course
#   turns smoothly, so the modules can follow.
# - $u$: a PID controller on the distance from the path. It pushes sideways, back to the path.
# - $w$: a PID controller on the heading. It holds it.
#
# `follow_step` is these four lines, with limits for $u$ and $w$. Course and heading on the eight of
# section 2:

# %%
courses = np.degrees(np.unwrap(log[2]))
lines = {"course": courses, "heading": np.degrees(log[1][:, 2])}
show(
    plots.plot_responses(log[0], {"Course and heading [deg]": lines}),
    f"On the eight the course runs from {courses.min():.0f}° to {courses.max():.0f}°; the heading stays "
    f"within {np.degrees(np.abs(log[1][:, 2])).max():.1f}° of 0.",
)

# %% [markdown]
# What is the sideways push good for? The same eight without it, and once on your own parts.

# %%
mine, course = robot_parts("mixed"), robot_parts("reference")
no_push = FollowSettings(across=PidGains(0.0))
runs = {"wrong: no push": steer(course, round_trip, no_push), "reference": log}
runs |= {"mine": steer(mine, round_trip)} if mine.mine else {}
rows = min(len(run[0]) for run in runs.values())
beside = {name: 1000 * run[5][:rows] for name, run in runs.items()}
rms = ", ".join(
    f"{name.split(': ')[-1]} {np.sqrt(np.mean(e**2)):.1f}" for name, e in beside.items()
)
show(
    plots.plot_responses(log[0][:rows], {"Off the path [mm]": beside}),
    f"Distance from the eight at up to 2 m/s in mm, RMS: {rms} ({mine.label}).",
)

# %% [markdown]
# ## 14. Link-up: from the start zone to Area 3
#
# Everything together. The robot plans its way over both ramps, follows it with the law of section
# 13, and knows its place from its own sensors. It has arrived when it stands within 0.2 m of the goal
# and its LiDAR says that y is above 8.45 m. Touching a fence is not allowed.
#
# First on your own parts, as far as they were accepted, with the noise of real sensors.

# %%
run = worlds.field_drive(student, mine, goal=field.AREA_3_GOAL, kind="noisy")
label = "mine" if mine.mine else "reference"
lost = 1000 * np.hypot(*(run.estimates - run.poses)[:, :2].T).max()
show(
    animate(
        run.time, {label: run.poses}, angles=run.module_angles, speeds=run.module_speeds, frames=60
    ),
    f"From the start zone to Area 3 over both ramps ({mine.label}): {run.reason}. It ends "
    f"{1000 * run.away:.0f} mm from the goal, LiDAR y {run.lidar_y:.2f} m, with {run.contacts} contacts. On the way its own "
    f"estimate is at most {lost:.0f} mm from the truth.",
)

# %% [markdown]
# How far from the path, and how fast? The profile says how long the drive has to take at least.

# %%
speed = np.hypot(*np.gradient(run.poses[:, :2], run.time, axis=0).T)
panels = {"Off the path [mm]": {label: 1000 * run.cross_track}, "Speed [m/s]": {label: speed}}
show(
    plots.plot_responses(run.time, panels),
    f"The drive to Area 3: {1000 * np.sqrt(np.mean(run.cross_track**2)):.0f} mm off the path, RMS, and "
    f"{1000 * np.abs(run.cross_track).max():.0f} mm at most; up to {speed.max():.1f} m/s. It takes {run.duration:.1f} s, "
    f"the profile {run.limit:.1f} s.",
)

# %% [markdown]
# Three rungs. *Ideal*: a robot as drawn, with perfect sensors. *Noisy*: your own robot, its sensors, and
# a floor with seams. *Degraded*: the same on a dusty, worn floor, with tired motors. Each once on the
# course's parts and once on yours. The same drive from a terminal, with your parts:
# `robocon drive --goal 4.3 10.0`.

# %%
for kind in ("ideal", "noisy", "degraded"):
    for name, parts in {"course": course, "yours": mine}.items():
        one = worlds.field_drive(student, parts, goal=field.AREA_3_GOAL, kind=kind)
        off = 1000 * np.sqrt(np.mean(one.cross_track**2))
        arrived = "arrived" if one.arrived else f"not there: {one.reason}"
        print(f"{kind:9s} {name:7s} {off:4.0f} mm off, RMS; {one.contacts} contacts; {arrived}")

# %% [markdown]
# ## 15. Challenge: settings for any cart (4 points)
#
# Write `tune(model, path)`. It gets a cart that nobody has seen, with its own lag, wheel base and top
# speed, and a path with bends and corners. It returns `tracking.TrackingSettings(k, least, speed,
# lateral)`.
#
# Then the cart drives. What counts is the largest distance from the path, in the worst of three
# drives: up to 1.1 cm earns all points, up to 1.5 cm half. Creeping would be easy, so there is a time
# limit, `tracking.time_allowed(path, model)`: on average at least half as fast as the wheels can.
#
# Ideas: which cart has to look farther ahead? How slow may it be in bends, when time is limited?
# `tracking.trial(path, model, settings)` takes some milliseconds, and says `worst` and `duration`.


# %% exercise="tracking.tune"
def tune(model, path):
    """Settings with which a cart keeps closest to a path, in time.

    model : tracking.DifferentialModel(wheel_base, lag, max_speed, …)
    path : (n, 2) array [m, map]
    returns : tracking.TrackingSettings(k, least, speed, lateral)
    """
    ### BEGIN SOLUTION
    best, off = tracking.TrackingSettings(), np.inf
    ahead = itertools.product((0.4, 0.6, 0.8, 1.0, 1.3), (0.02, 0.03, 0.04))
    fast = itertools.product((0.65, 0.8, 0.9), (0.2, 0.4, 0.8, 1.6, 3.0))
    for (lags, least), (share, lateral) in itertools.product(ahead, fast):
        k, speed = lags * model.lag, share * model.max_speed
        settings = tracking.TrackingSettings(k, least, speed, lateral)
        run = tracking.trial(path, model, settings)
        if run.duration <= tracking.time_allowed(path, model) and run.worst < off:
            best, off = settings, run.worst
    return best
    ### END SOLUTION


# %% check="tracking.tune"
tune = check("tracking.tune")

# %%
rng = worlds.generator(student, "one more cart")
model, path = worlds.some_cart(rng), worlds.winding_path(rng)
guess = TrackingSettings(0.1, 0.05, 0.8 * model.max_speed, 1.0)
runs = {
    "wrong: a guess": tracking.trial(path, model, guess),
    "mine: tuned": tracking.trial(path, model, tune(model, path)),
}
show(
    plots.plot_path_errors(path, runs),
    f"A cart with a lag of {model.lag:.3f} s. With a guess it is up to {100 * runs['wrong: a guess'].worst:.1f} cm off "
    f"its path, tuned {100 * runs['mine: tuned'].worst:.1f} cm.",
)

# %% [markdown]
# ## 16. Summary
#
# - P pushes, I removes what stays, D brakes: minus the derivative of the measurement.
# - At a limit the integral waits. A lost sample changes nothing but counters.
# - Raise P until it swings; half of that is a place to begin.
# - Nearest point on a segment, from where the robot was last time, not farther than it can have come.
# - Look ahead farther with lag and speed; the longer, the gentler, and the more a corner is cut.
# - Speed: bends first, then forwards, then backwards from the end.
# - A swerve robot steers its course, not itself.
#
# **Ask yourself.** Why does P alone never remove a steady pull? When do the derivatives of error and
# measurement differ? Why does the critical gain fall when a pose is late? Why is the curvature of pure
# pursuit on a circle the circle's, whatever the look-ahead? What does a speed profile look like for a
# path of two points? Why does the backward pass need no second forward pass?
#
# ## Glossary
#
# | English | Bahasa Indonesia |
# |---|---|
# | setpoint | titik setel, nilai acuan |
# | measurement | hasil pengukuran |
# | error | galat |
# | gain | penguatan |
# | overshoot | lonjakan maksimum |
# | wind-up | penumpukan integral |
# | path | lintasan |
# | look-ahead distance | jarak pandang ke depan |
# | curvature | kelengkungan |
# | cross-track error | simpangan dari lintasan |
# | speed profile | profil kecepatan |
# | lag | kelambatan |
#
# ## Reading
#
# K. J. Åström, R. M. Murray, *Feedback Systems*, 2nd edition, 2021, chapter 11: PID controllers, wind-up,
# and both forms. The book is free on its authors' site.
#
# R. C. Coulter, *Implementation of the Pure Pursuit Path Tracking Algorithm*, Carnegie Mellon University,
# 1992: the circle, and what the look-ahead does, in few pages.
#
# Sources of the printed formulas: B. S. Marta, F. Ardilla, A. R. A. Besari, on path tracking with odometry
# feedback, Politeknik Elektronika Negeri Surabaya; and the thesis on a swerve-drive robot of Universitas
# Negeri Yogyakarta, 2024, chapters on pure pursuit and PID.
#
# ## Where you are

# %%
status()

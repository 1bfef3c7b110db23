# %% [markdown]
# # 00 · Start here
#
# In this course you write the autonomy of a competition robot.
# Each chapter adds a part. In the end your robot plays a match on your own code.
#
# | | |
# |---|---|
# | Time | 30 minutes |
# | You need | Python functions |
# | Points | 1 |
# | You hand in | one function: `wrap_angle` |

# %% [markdown]
# ## 1. Begin
#
# Put your student number in place of `None`, and run the cell with **Shift + Enter**.
# If it holds letters or begins with 0, write it in quotes: `"H1D021001"`.
# The number gives you a robot of your own: the errors of its sensors and sizes are yours alone.
# The course remembers it for the chapters to come.

# %%
import math

import numpy as np

from robocon_course.exercises import begin, check, hint, robot_parts, status
from robocon_course.view import explore, figure, pictures, show

student = begin("start", student=None)

# %% [markdown]
# Is this computer ready? The doctor says so in one line.
# In a terminal, `robocon doctor` shows the whole list.

# %%
from robocon_course import doctor

print(doctor.summary())

# %% [markdown]
# ## 2. The match
#
# ABU Robocon 2024 is called *Harvest Day*. Two teams share a field of 12 m × 12 m.
# Robot 2 is on its own: nobody steers it.
# It starts at the bottom, climbs two ramps, and carries rice balls to five silos in the middle.
# Dark edges are steps of 0.10 m: the robot cannot climb them, only the ramps lead up.
# The match lasts three minutes.

# %%
from robocon_course import field

silos = ", ".join(f"({x:g}, {y:g})" for x, y in field.SILOS)
show(
    pictures.draw_plan(),
    f"Plan of the field, {field.SIZE:g} m square. The robot starts at (0.55, 0.35) m and drives "
    f"over two ramps to Area 3, (4.3, 10) m. Silos at {silos} m.",
)

# %% [markdown]
# This is what you will have built at the end: the robot plays a match by itself.
#
# The film runs six times as fast as the match. The robot is white, with its gripper ahead of the
# triangle; the line behind it is where it just was. Words at the top left say what it does.
#
# A ball of its own colour in a silo gives 30 points. A ball with a white middle is empty and must not
# be touched. At the right are the silos as stacks. Three that count are *Mua Vang*: the match is won at
# once. A silo counts for a team if it is full, with two balls of that team or more and one of them on top.

# %%
show(*pictures.match_film())

# %% [markdown]
# The **map frame** has its origin in the corner on our outer side.
# `x` points to the middle of the field, `y` towards Area 3, in metres.
# Angles count anticlockwise from `x`, in radians.

# %% [markdown]
# ## 3. The robot
#
# Four swerve modules drive it: each wheel has its own direction.
# Three small wheels without a motor measure the way. A phone is the IMU.
# Four LiDARs, one to each side, measure the distance to the fences. A camera sees balls and silos.

# %%
show(
    pictures.draw_robot(),
    "The robot from above: 650 mm square, four swerve modules in the corners, three measuring "
    "wheels (left, right, rear), a phone as IMU, four LiDARs, a camera and a gripper. "
    "x points forward, y to the left.",
)

# %% [markdown]
# ## 4. What you will build
#
# Everything the robot knows comes in as an *Observation*. Everything it does goes out as a *Command*.
# Between them stand small functions. Each chapter is one of the boxes.

# %%
show(
    pictures.draw_system(),
    "From Observation to Command in boxes: calibration and attitude (01), odometry (02), swerve (03), "
    "A* (04), pursuit with PID (05), vision (06), mission (07), particle filter (08), occupancy "
    "grid (09).",
)

# %% [markdown]
# ## 5. How a check works
#
# Your first part is small, and the robot needs it everywhere.
# A direction of 190° is the same as −170°. A robot that does not know this turns the long way round.
# The course keeps angles in the range $[-\pi, \pi)$.
#
# Here is a wrong answer, on purpose. Run it and read what the check says.


# %%
def wrap_angle(angle):
    """Wrong on purpose."""
    return angle % (2 * math.pi)


wrap_angle = check("start.wrap_angle", practice=True)

# %% [markdown]
# A check has four answers, each with a sign and a word:
#
# | | |
# |---|---|
# | ✔ passed | the function is right and becomes part of your robot |
# | ✘ wrong | the first case that failed, and often the likely cause by name |
# | – not attempted | there is still only the empty frame |
# | ! error | your code raised something, or never ended |
#
# Whatever it says, the notebook goes on: later cells use your function if it was accepted, and the
# course's if not. You can check as often as you like.

# %% [markdown]
# ### Exercise: wrap an angle (1 point)
#
# Write the function so that any angle comes out in $[-\pi, \pi)$.
# Delete the lines `# YOUR CODE HERE` and `raise …` under the docstring, write yours, run the cell,
# then run the check.


# %% exercise="start.wrap_angle"
def wrap_angle(angle):
    """The same direction as an angle in [-π, π).

    angle : float [rad], any number of turns
    returns : float [rad]
    """
    ### BEGIN SOLUTION
    return (angle + math.pi) % (2 * math.pi) - math.pi
    ### END SOLUTION


# %% check="start.wrap_angle"
wrap_angle = check("start.wrap_angle")

# %% [markdown]
# Stuck? Ask for a hint. `hint("start.wrap_angle", 2)` says more.

# %%
hint("start.wrap_angle")

# %% [markdown]
# ## 6. Play
#
# A heading that adds up turn after turn, before and after wrapping.
# Under many figures there are sliders. Move this one.


# %%
def draw_heading(turns):
    """A heading that grows to some turns, raw and wrapped."""
    heading = np.linspace(0.0, turns * 2 * math.pi, 600)
    wrapped = np.array([wrap_angle(angle) for angle in heading])
    fig, ax = figure(7.0, 3.0)
    ax.plot(heading, heading, "--", color="0.6", label="raw")
    jumps = np.abs(np.diff(wrapped, prepend=wrapped[0])) > math.pi
    ax.plot(heading, np.where(jumps, np.nan, wrapped), label="wrapped")
    ax.set(xlabel="angle turned [rad]", ylabel="heading [rad]")
    ax.legend(loc="upper left")
    twin = f"After {turns:g} turns the raw heading is {heading[-1]:.2f} rad, wrapped {wrapped[-1]:.2f} rad."
    return fig, twin


explore(draw_heading, turns=(-3.0, 3.0, 0.25, 1.75))

# %% [markdown]
# ## 7. Link-up: your robot
#
# An accepted answer is written to the folder `my_robot/` beside this notebook, every version of it.
# From then on the robot can run on your part. Parts you have not written yet are the course's.

# %%
parts = robot_parts("mixed")
print(f"Parts in use: {parts.label}")
print(f"wrap_angle(190°) = {math.degrees(parts.wrap_angle(math.radians(190))):.0f}°")

# %% [markdown]
# ## 8. Summary
#
# - Run cells from top to bottom with Shift + Enter.
# - Write the function, check it, read the verdict, ask for hints.
# - Accepted functions become your robot.
#
# **Ask yourself.** What is −190° in the range [−180°, 180°)? Why is the range open on one side?
# What would a robot do that compares 179° with −179° by subtracting?
#
# ## Glossary
#
# | English | Bahasa Indonesia |
# |---|---|
# | angle | sudut |
# | heading | arah hadap |
# | turn left (anticlockwise) | belok kiri (berlawanan arah jarum jam) |
# | field | lapangan |
# | ramp | bidang miring |
# | exercise | latihan |
# | hint | petunjuk |
#
# ## Reading
#
# REP-103, *Standard Units of Measure and Coordinate Conventions* (ROS): the frames and units used here.
#
# ## Where you are

# %%
status()

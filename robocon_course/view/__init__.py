"""Figures and sliders: this room draws what it is given and decides nothing.

``canvas`` holds the style and what shows a figure, ``plots`` the plots of the chapters,
``comparison`` the picture of a wrong answer, ``pictures`` the three big drawings and ``widgets``
the sliders.
"""

from robocon_course.view.canvas import figure, png, show
from robocon_course.view.comparison import plot_counter_example
from robocon_course.view.pictures import draw_plan, draw_robot, draw_system
from robocon_course.view.plots import (
    plot_angles,
    plot_imu,
    plot_sphere,
    plot_still,
    plot_tilt_error,
)
from robocon_course.view.widgets import explore

__all__ = [
    "draw_plan",
    "draw_robot",
    "draw_system",
    "explore",
    "figure",
    "plot_angles",
    "plot_counter_example",
    "plot_imu",
    "plot_sphere",
    "plot_still",
    "plot_tilt_error",
    "png",
    "show",
]

"""Figures and sliders: this room draws what it is given and decides nothing.

``canvas`` holds the style and what shows a figure; ``plots``, ``motion``, ``runs`` and ``tracking``
the plots of the chapters, ``field_picture`` the field with robots (``body``) and paths on it,
``searching`` maps, ways and how a search went. ``seeing`` draws pictures with boxes and how good
a detector is, ``looking`` films, places, and balls from above. ``comparison`` is the picture of a
wrong answer, ``pictures`` the three big drawings, ``widgets`` the sliders, ``driving`` a robot
under one's own hands, ``matches`` a match as film and figure, ``dashboard`` the screen of its
operator, ``playing`` a match in real time behind it, and ``lanes`` arrows between boxes.
"""

from robocon_course.view.animation import animate
from robocon_course.view.body import RobotPicture
from robocon_course.view.canvas import figure, png, show
from robocon_course.view.comparison import plot_counter_example
from robocon_course.view.driving import drive
from robocon_course.view.field_picture import OUR_HALF, WHOLE_FIELD, draw_field
from robocon_course.view.matches import animate_match, match_twin, plot_match
from robocon_course.view.motion import plot_modules, plot_paths, plot_pose_errors, plot_tracking
from robocon_course.view.pictures import draw_plan, draw_robot, draw_system
from robocon_course.view.plots import (
    plot_angles,
    plot_imu,
    plot_sphere,
    plot_still,
    plot_tilt_error,
)
from robocon_course.view.runs import plot_distribution
from robocon_course.view.searching import animate_search, draw_ways
from robocon_course.view.tracking import (
    plot_path_errors,
    plot_pursuit,
    plot_responses,
    plot_source_paths,
    plot_speeds,
)
from robocon_course.view.widgets import explore

__all__ = [
    "OUR_HALF",
    "WHOLE_FIELD",
    "RobotPicture",
    "animate",
    "animate_match",
    "animate_search",
    "draw_field",
    "draw_plan",
    "draw_robot",
    "draw_system",
    "draw_ways",
    "drive",
    "explore",
    "figure",
    "match_twin",
    "plot_angles",
    "plot_counter_example",
    "plot_distribution",
    "plot_imu",
    "plot_match",
    "plot_modules",
    "plot_path_errors",
    "plot_paths",
    "plot_pose_errors",
    "plot_pursuit",
    "plot_responses",
    "plot_source_paths",
    "plot_speeds",
    "plot_sphere",
    "plot_still",
    "plot_tilt_error",
    "plot_tracking",
    "png",
    "show",
]

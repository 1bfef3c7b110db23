"""Chapter 04: which way leads there, past everything that stands around?

    obstacle map → room for the robot's middle → A* → cells → shortened → smooth
                              ↑ an obstacle is seen on the way: again from here

==============  ==================================================================
``plans``       `Plan`, `NoPathError`: what every search is given and gives
``shortest``    A* in metres: weights, estimates, again with falling weight
``steps``       one cell: its open neighbours, what steps cost, what is left
``search``      its kernels: costs, steps, buckets; read them as ``.py_func``
``moves``       one step, for the kernels: what it costs, whether it is open and worth a try
``path``        a way as a row of points: length, thinner, evenly spread
``sight``       what is in sight of what; a way without needless points
``smoothing``   a way that nowhere bends more than a limit
``replanning``  D* Lite: mend the plan when the map changes
``journey``     drive through obstacles that are only seen on the way
==============  ==================================================================
"""

from robocon_course.planning.journey import Journey, Leg, travel, visible_cells
from robocon_course.planning.path import path_length, resample_path, thin_path
from robocon_course.planning.plans import NoPathError, Plan, nearest_free, plan_through
from robocon_course.planning.replanning import Replanner
from robocon_course.planning.shortest import Attempt, anytime_astar, astar
from robocon_course.planning.sight import line_of_sight, shorten_path
from robocon_course.planning.smoothing import path_curvature, smooth_path
from robocon_course.planning.steps import neighbours, octile_distance

__all__ = [
    "Attempt",
    "Journey",
    "Leg",
    "NoPathError",
    "Plan",
    "Replanner",
    "anytime_astar",
    "astar",
    "line_of_sight",
    "nearest_free",
    "neighbours",
    "octile_distance",
    "path_curvature",
    "path_length",
    "plan_through",
    "resample_path",
    "shorten_path",
    "smooth_path",
    "thin_path",
    "travel",
    "visible_cells",
]

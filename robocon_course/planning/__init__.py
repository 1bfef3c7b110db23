"""Chapter 04: which way leads there, past all that stands around?

    obstacle map → room for the robot's middle → A* → a way → shortened → smooth

==============  ================================================================
``plans``       `Plan`, `NoPathError`; what every search is given and gives
``astar``       A* in metres, with a weight, and again with falling weight
``search``      the kernels: buckets, costs, steps; read them as ``.py_func``
==============  ================================================================
"""

from robocon_course.planning.astar import Attempt, anytime_astar, astar
from robocon_course.planning.plans import NoPathError, Plan, nearest_free

__all__ = ["Attempt", "NoPathError", "Plan", "anytime_astar", "astar", "nearest_free"]

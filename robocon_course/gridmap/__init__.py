"""Where may the robot drive? A bitmap with a scale: free cells and all the others.

==========  ========================================================
``grid``    the map, from points to cells and back
``room``    boxes put on it, and room for a body: a disc or a square
``files``   ROS map files in and out
``octile``  benchmark maps, and pairs to plan between
==========  ========================================================
"""

from robocon_course.gridmap.files import load_map, save_map
from robocon_course.gridmap.grid import GridMap
from robocon_course.gridmap.octile import Scenario, load_scenarios
from robocon_course.gridmap.room import inflate, inflate_square, put_boxes

__all__ = [
    "GridMap",
    "Scenario",
    "inflate",
    "inflate_square",
    "load_map",
    "load_scenarios",
    "put_boxes",
    "save_map",
]

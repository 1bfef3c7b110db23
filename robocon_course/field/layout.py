"""The game field of ABU Robocon 2024 "Harvest Day", in numbers.

Map frame: metres, origin at the inner corner of the fence on our outer side, x towards the centre
of the field, y from Area 1 to Area 3, z above the ground under the stage. Everything here is our
half, with the colours of the red team; the opponent's half is its mirror image, x -> 12 - x. The
silos stand on the centre line and belong to both.

Source: the rulebook's top view and two teams' CAD models and program constants, which agree to
about 10 mm. Where CAD and drawing differ, the value lies between them. What rests on one source, or
on none, says so beside its value.
"""

from __future__ import annotations

from typing import NamedTuple

Colour = tuple[int, int, int]
Point = tuple[float, float]

ORANGE: Colour = (255, 170, 77)
GREEN: Colour = (80, 158, 47)
YELLOW: Colour = (254, 209, 65)
WATER_BLUE: Colour = (153, 214, 234)
GREY: Colour = (158, 162, 162)
WHITE: Colour = (255, 255, 255)
RED: Colour = (240, 50, 65)
BLUE: Colour = (50, 120, 225)
PURPLE: Colour = (160, 85, 155)


class Rect(NamedTuple):
    """A rectangle of floor, or a box that stands on it.

    Attributes
    ----------
    name : str
    x0, y0, x1, y1 : float  [m, map]
        Lower left and upper right corner.
    height : float  [m]
        Floor at (x0, y0), or top of the box, above the ground under the stage.
    colour : (r, g, b), 0 to 255
    slope : (float, float)
        Rise of the floor per metre along x and along y.
    """

    name: str
    x0: float
    y0: float
    x1: float
    y1: float
    height: float
    colour: Colour
    slope: Point = (0.0, 0.0)

    @property
    def centre(self) -> Point:
        """Middle of the rectangle [m, map]."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    def contains(self, x: float, y: float) -> bool:
        """Whether the point (x, y) [m, map] lies in the rectangle or on its edge."""
        return self.x0 <= x <= self.x1 and self.y0 <= y <= self.y1

    def height_at(self, x: float, y: float) -> float:
        """Height of the floor at (x, y) [m, map], above the ground under the stage [m]."""
        return self.height + self.slope[0] * (x - self.x0) + self.slope[1] * (y - self.y0)


class Line(NamedTuple):
    """Centre line of a white line on the floor, from (x0, y0) to (x1, y1) [m, map]."""

    x0: float
    y0: float
    x1: float
    y1: float


SIZE = 12.0
"""Side of the square field, inside the fence [m]."""
EDGE = 5.875
"""Where our half ends and the strip between the teams begins [m]."""
FENCE_THICKNESS = 0.05
FENCE_HEIGHT = 0.10
LINE_WIDTH = 0.03

# The floor: these rectangles tile our half and the strip in the middle.
AREA_1 = Rect("Area 1", 0.0, 0.0, EDGE, 4.0, 0.05, ORANGE)
AREA_2 = Rect("Area 2", 0.0, 4.0, EDGE, 8.0, 0.15, GREEN)
STORAGE_ZONE = Rect("Storage Zone", 0.0, 8.0, 2.25, 12.0, 0.15, GREEN)
SIDE_SLOPE = Rect("side slope", 2.25, 8.0, 3.25, 12.0, 0.15, YELLOW, (0.1, 0.0))
AREA_3 = Rect("Area 3", 3.25, 8.0, EDGE, 12.0, 0.25, YELLOW)
DIVIDER_1 = Rect("divider of Area 1", EDGE, 0.0, 6.125, 4.0, 0.145, GREY)
DIVIDER_2 = Rect("divider of Area 2", EDGE, 4.0, 6.125, 8.0, 0.245, GREY)
SILO_ZONE = Rect("Silo Zone", EDGE, 8.0, 6.125, 12.0, 0.35, GREY)
FLOOR = (AREA_1, AREA_2, STORAGE_ZONE, SIDE_SLOPE, AREA_3, DIVIDER_1, DIVIDER_2, SILO_ZONE)

# What stands on the floor or is let into it.
RAMP_1 = Rect("ramp 1", 0.0, 3.0, 1.0, 4.0, 0.05, ORANGE, (0.0, 0.1))
RAMP_2 = Rect("ramp 2", 3.8, 7.0, 4.8, 8.0, 0.15, GREEN, (0.0, 0.1))
WATER_FRAME = Rect("water frame", 0.0, 7.0, 3.8, 8.0, 0.25, GREY)
WATER = Rect("Water Zone", 0.0, 7.05, 3.75, 7.95, 0.05, WATER_BLUE)
START_ZONE = Rect("start of Robot 2", 0.15, 0.0, 0.85, 0.7, 0.05, RED)
START_ZONE_R1 = Rect("start of Robot 1", 0.9, 0.0, 1.6, 0.7, 0.05, RED)
RETRY_ZONE = Rect("Retry Zone", 0.0, 5.15, 0.7, 5.85, 0.15, RED)
SEEDLING_RACK = Rect("seedling rack", 2.0, 0.0, 5.25, 0.25, 0.11, GREY)
ZONES = (START_ZONE, START_ZONE_R1, RETRY_ZONE, SEEDLING_RACK, RAMP_1, RAMP_2)

# What a beam hits and the body cannot enter. Heights are those of the top.
WATER_BACK = Rect("back of the water frame", 0.0, 7.95, 3.8, 8.0, 0.35, GREY)
"""The frame's side towards Area 3 rises as far above the platform as the fence."""
_RIM = FENCE_THICKNESS
FENCES = (
    Rect("fence of Area 1", -_RIM, -_RIM, 0.0, 4.0, 0.15, GREY),
    Rect("fence of Area 2", -_RIM, 4.0, 0.0, 8.0, 0.25, GREY),
    Rect("fence of the Storage Zone", -_RIM, 8.0, 0.0, SIZE + _RIM, 0.35, GREY),
    Rect("start fence", 0.0, -_RIM, SIZE / 2, 0.0, 0.15, GREY),
    Rect("end fence", 0.0, SIZE, SIZE / 2, SIZE + _RIM, 0.35, GREY),
)
"""Boards around our half: 0.10 m above the floor beside them, 0.20 m in the Storage Zone. One CAD
model has 0.12 m, but stands 0.02 m too high."""
LEDGES = (
    Rect("ledge of Area 2", 1.0, 3.95, EDGE, 4.0, 0.15, GREY),
    Rect("side of ramp 1", 1.0, 3.0, 1.05, 4.0, 0.15, GREY),
    Rect("ledge of Area 3", 4.8, 7.95, EDGE, 8.0, 0.25, GREY),
    Rect("side of ramp 2", 4.8, 7.0, 4.85, 8.0, 0.25, GREY),
)
"""Steps too high to climb. They have no thickness: these boxes lie on the floor below each."""
OBSTACLES = (
    *FENCES,
    *LEDGES,
    WATER_FRAME,
    WATER_BACK,
    SEEDLING_RACK,
    DIVIDER_1,
    DIVIDER_2,
    SILO_ZONE,
    Rect("other half", SIZE / 2, -_RIM, SIZE + _RIM, SIZE + _RIM, 0.35, GREY),
)
"""What the chassis cannot enter. The frame of boards around the pile is none of them: how high its
boards are was not found, so whether the robot clears them is not known."""

# Spots.
SILOS: tuple[Point, ...] = tuple((6.0, 8.5 + 0.75 * k) for k in range(5))
"""Centres of silos 1 to 5, counted from Area 2 towards the end fence."""
SILO_DIAMETER = 0.25
SILO_HEIGHT = 0.425
"""Above the Silo Zone [m]: an open cage of four rings on posts."""
SILO_BORE = 0.238
"""Inner diameter of its rings in one team's CAD model [m]."""
SILO_CAPACITY = 3
SILO_LAYERS = (0.095, 0.280, 0.465)
"""Middles of the balls in a full silo, above the Silo Zone [m]; reckoned from bore and ball."""
RELEASE_HEIGHT = 0.74
"""Above the platform, where one team's robot lets go of a ball over a silo [m]."""
SPOT_DIAMETER = 0.12
HOLE_DIAMETER = 0.09
HARVEST_RECESS = 0.02
"""Depth of the harvest spots in one team's CAD model [m]."""
BALL_DIAMETER = 0.19
BALL_MASS = 0.30
"""Assumed [kg]: the rulebook's value was not found, one simulation has 0.35."""
SEEDLING_HOLES: tuple[Point, ...] = tuple((2.25 + 0.25 * k, 0.125) for k in range(12))
_COLUMNS = [2.375 + 0.5 * k for k in range(6)]
PLANTING_SPOTS: tuple[Point, ...] = tuple((x, y) for y in (2.25, 2.75) for x in _COLUMNS)
HARVEST_SPOTS: tuple[Point, ...] = tuple((x, y) for y in (5.25, 5.75) for x in _COLUMNS)
HARVEST_EXAMPLE = (RED, PURPLE) * 3 + (PURPLE, RED) * 3
"""Colours of the balls on `HARVEST_SPOTS` in the rulebook's picture; the opponent sets them."""
PILE: Point = (1.125, 10.0)
PILE_HALF_DIAGONAL = 0.6
PILE_FRAME_WIDTH = 0.05
"""Of the boards of the square frame around the pile; assumed like the fence's [m]."""
_DIAGONAL = BALL_DIAMETER * 0.5**0.5
PILE_BALLS: tuple[Point, ...] = tuple(
    (PILE[0] + _DIAGONAL * (i - j), PILE[1] + _DIAGONAL * (i + j - 3))
    for i in range(4)
    for j in range(4)
)
"""Centres of the 16 balls of the pile: a 4 x 4 grid turned by 45 degrees."""
PILE_EXAMPLE = tuple(RED if i + j in (2, 4) else PURPLE for i in range(4) for j in range(4))
"""Colours of `PILE_BALLS` in the rulebook's picture: 6 of ours, 10 empty."""

STEPS = (Line(1.0, 4.0, EDGE, 4.0), Line(4.8, 8.0, EDGE, 8.0))
"""Edges where the floor rises by 0.10 m at once."""

# White lines, Robot 2's first.
GUIDE_LINES = (
    Line(0.5, 0.0, 0.5, 6.42),
    Line(0.5, 6.42, 4.3, 6.42),
    Line(4.3, 6.42, 4.3, 11.5),
    *(Line(4.3, y, EDGE, y) for _, y in SILOS),
    Line(1.725, 10.0, 4.3, 10.0),
    Line(0.15, 0.35, 0.85, 0.35),
    Line(0.0, 5.5, 0.5, 5.5),
)
FRAME_LINES = (
    Line(1.89, 5.01, EDGE, 5.01),
    Line(1.89, 5.98, EDGE, 5.98),
    Line(1.89, 5.01, 1.89, 5.98),
    Line(1.89, 2.02, EDGE, 2.02),
    Line(1.89, 2.965, EDGE, 2.965),
    Line(1.89, 2.02, 1.89, 2.965),
)
ROBOT_1_LINES = (
    Line(0.5, 1.35, 3.625, 1.35),
    Line(1.438, 1.35, 1.438, 3.489),
    Line(1.438, 3.489, 3.68, 3.489),
    Line(3.68, 2.965, 3.68, 3.489),
    Line(3.625, 0.25, 3.625, 2.02),
)

# Where the robot's program sends it.
START: Point = (0.55, 0.35)
AREA_3_GOAL: Point = (4.30, 10.0)
AREA_3_LINE = 8.45
"""Above this y the robot counts as being in Area 3 [m]."""
SEEDLINGS = 12
"""A Robot 1 has so many; it may send no more balls than it has planted of them."""
MATCH_LENGTH = 180.0
"""[s]"""
PILE_TARGET: Point = (1.0, 9.98)
"""Target of gripper and camera; the robot's body has to stop before it."""
SILO_POST: Point = (4.2, 9.98)
WAY_TO_AREA_3: tuple[Point, ...] = (START, (0.55, 6.42), (4.3, 6.42), AREA_3_GOAL)
"""By hand, along the guide lines and over both ramps."""

"""Figures and sliders: this room draws what it is given and decides nothing."""

from robocon_course.view.canvas import figure, png, show
from robocon_course.view.widgets import explore

__all__ = ["explore", "figure", "png", "show"]

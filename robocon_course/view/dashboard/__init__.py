"""The operator's screen in JupyterLab: everything that is told on the bus, and the buttons.

==============  =============================================================
``screen``      `dashboard`, `Dashboard`: the panes side by side, and their clock
``inbox``       what was heard on the bus, kept until it is drawn
``field_map``   the robot on its field
``sight``       the camera's picture with what was found in it
``readings``    the sensors in numbers
``states``      the mission's states as a picture
``journal``     the event log, and the status bar
``controls``    buttons, sliders, keys and gamepad
``markup``      words, numbers and colours of the page
==============  =============================================================

The screen knows nothing but the bus; whether a simulator, a replayed log or the machine itself
speaks there makes no difference.
"""

from robocon_course.view.dashboard.screen import Dashboard, dashboard

__all__ = ["Dashboard", "dashboard"]

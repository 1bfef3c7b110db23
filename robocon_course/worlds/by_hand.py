"""What the operator asks for with stick and buttons, as commands for the robot."""

from __future__ import annotations

from math import isfinite, nan

from robocon_course.autopilot import Parts, module_command
from robocon_course.robot import Command, Observation
from robocon_course.robot.messages import Button, Twist

CYCLE = 0.01
"""Of control [s]."""
LETS_GO = 0.7
"""So long the gripper is told to let go after its button [s]."""


class ByHand:
    """What the operator's stick and buttons ask for.

    Attributes
    ----------
    on : bool
        Whether they drive in place of the autopilot.
    """

    def __init__(self) -> None:
        self.on = False
        self._twist = (0.0, 0.0, 0.0)
        self._held: dict[str, float] = {}

    def steer(self, topic: str, twist: Twist) -> None:
        """The stick moved; one that is nowhere is in the middle."""
        try:
            asked = float(twist.vx), float(twist.vy), float(twist.omega)
        except (AttributeError, TypeError, ValueError):
            asked = (nan,) * 3
        self._twist = asked if all(map(isfinite, asked)) else (0.0, 0.0, 0.0)

    def press(self, button: Button) -> None:
        """A button that is about driving by hand; others mean nothing here.

        Raises
        ------
        ValueError
            An angle or a speed of the rollers that is no number.
        """
        name, value = button.name, button.value
        if name == "manual":
            self.on = value in ("on", 1.0)
            self._twist, self._held = (0.0, 0.0, 0.0), {}
        elif name in ("stop", "set_up"):
            self.on = False
        elif name in ("intake", "pan", "tilt"):
            number = value if isinstance(value, int | float) else nan
            if not isfinite(number):
                raise ValueError(f"{name}: expected a number, got {value!r}")
            self._held[name] = float(number)
        elif name == "release":
            self._held["release"] = LETS_GO
            self._held["intake"] = 0.0

    def command(self, parts: Parts, seen: Observation) -> Command:
        """What they ask for, as a command; the stick's axes are the robot's own."""
        order = module_command(parts, self._twist, 0.0, seen.module_angles, dt=CYCLE)
        left = self._held.get("release", 0.0)
        self._held["release"] = max(0.0, left - CYCLE)
        return Command(
            order.speeds, order.angles, self._held.get("intake", 0.0), left > 0.0,
            self._held.get("pan", 0.0), self._held.get("tilt", 0.3), "ball",
        )  # fmt: skip

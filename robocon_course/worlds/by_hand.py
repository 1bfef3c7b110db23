"""What the operator asks for with stick and buttons, as commands for the robot."""

from __future__ import annotations

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
        """The stick moved."""
        self._twist = (float(twist.vx), float(twist.vy), float(twist.omega))

    def press(self, button: Button) -> None:
        """A button that is about driving by hand."""
        if button.name == "manual":
            self.on = button.value in ("on", True)
            self._twist, self._held = (0.0, 0.0, 0.0), {}
        elif button.name in ("intake", "pan", "tilt"):
            self._held[button.name] = float(button.value)
        elif button.name == "release":
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

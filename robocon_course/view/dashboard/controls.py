"""What the operator touches: buttons, sliders, keys, a gamepad. Each tells the bus, nobody else.

A browser's text field tells which keys are typed, and a key that is held down repeats. So the robot
drives as long as a key repeats, and stands when it is let go: never longer than `HELD`.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager
from math import degrees, radians
from typing import Any

import ipywidgets as w

from robocon_course.robot import messages
from robocon_course.view.dashboard.inbox import Inbox
from robocon_course.view.stick import LIMITS, NAMES, pushed
from robocon_course.vision.camera import SERVO_RANGE

KEYS = {
    "w": (0.5, 0.0, 0.0),
    "s": (-0.5, 0.0, 0.0),
    "a": (0.0, 0.5, 0.0),
    "d": (0.0, -0.5, 0.0),
    "q": (0.0, 0.0, 0.5),
    "e": (0.0, 0.0, -0.5),
    " ": (0.0, 0.0, 0.0),
}
"""Shares of the stick's way: forward and back, left and right, turn left and right, halt."""
HELD = 0.7
"""A key that has not repeated for so long was let go [s]; repeating begins after about half."""
PATIENCE = 10.0
"""A stick that nobody touches goes back to the middle after this time [s]."""
PAN = 90
"""How far the camera turns to each side [degrees]."""
ROLLERS = (("in", 1.0), ("hold", 0.0), ("out", -1.0))


class Controls:
    """Buttons and sliders, and who may be pressed when.

    Parameters
    ----------
    inbox : Inbox
        What was heard; what is told goes through it.
    clock : callable
        Wall time [s].

    Attributes
    ----------
    start, stop, retry : Button
    colour, side, intake : ToggleButtons
    manual : ToggleButton
    sliders : list of FloatSlider
        vx, vy and omega.
    release : Button
    pan, tilt : IntSlider  [degrees]
    keys : Text
        Where keys are typed.
    pad : Controller
    widget : VBox
        All of it.
    """

    def __init__(self, inbox: Inbox, clock: Callable[[], float]) -> None:
        self._inbox, self._clock = inbox, clock
        self._touched = clock()
        self._held: float | None = None
        self._quiet = False
        self._followed: Any = None
        self._make_match()
        self._make_stick()
        self._make_gripper()
        self.widget = self._laid_out()
        self.refresh()

    def refresh(self) -> None:
        """Free what makes sense now, and tell the bus again where the stick stands."""
        self._follow_crew()
        connected, running = self._inbox.connected(), self._inbox.running
        manual = self.manual.value
        self.start.disabled = running
        self.retry.disabled = not (running and connected)
        self.colour.disabled = self.side.disabled = running
        self.manual.disabled = not (connected or manual)
        for one in (*self.sliders, self.keys, self.intake, self.release, self.pan, self.tilt):
            one.disabled = not (manual and connected)
        self._let_go(connected)
        if manual:
            self._steer()
        else:
            self._follow_camera()

    def close(self) -> None:
        """Stand still, and go from the page."""
        if self.manual.value:
            self.manual.value = False
        self.pad.close()
        self.widget.close()

    # --- making -------------------------------------------------------------------------------

    def _make_match(self) -> None:
        self.start = self._button("Start", "play", "primary")
        self.stop = self._button("Stop", "stop", "danger")
        self.retry = self._button("Retry", "undo", "")
        self.start.on_click(self._pressed_start)
        self.stop.on_click(self._pressed_stop)
        self.retry.on_click(lambda _: self._tell("retry"))
        self.colour = _choice("Balls", (("red", "red"), ("blue", "blue")))
        self.side = _choice("Side", (("left", "left"), ("right", "right")))
        for name, one in (("colour", self.colour), ("side", self.side)):
            one.observe(lambda change, name=name: self._chose(name, change["new"]), names="value")

    def _make_stick(self) -> None:
        self.manual = w.ToggleButton(False, description="Drive by hand", icon="gamepad")
        self.manual.observe(self._took_over, names="value")
        self.keys = w.Text(placeholder="or hold WASD, QE", continuous_update=True)
        self.keys.observe(self._typed, names="value")
        self.sliders = [
            w.FloatSlider(0.0, min=-end, max=end, step=0.1, description=name, **_SLIM)
            for name, end in zip(NAMES, LIMITS, strict=True)
        ]
        for slider in self.sliders:
            slider.observe(self._moved, names="value")
        self.pad = w.Controller(index=0)
        self.pad.observe(self._plugged, names="axes")

    def _make_gripper(self) -> None:
        self.intake = _choice("Intake", ROLLERS, "hold")
        self.intake.observe(lambda change: self._tell("intake", change["new"]), names="value")
        self.release = self._button("Release", "arrow-down", "")
        self.release.on_click(self._pressed_release)
        low, high = (round(degrees(end)) for end in SERVO_RANGE)
        self.pan = w.IntSlider(0, min=-PAN, max=PAN, description="pan [°]", **_SLIM)
        self.tilt = w.IntSlider(0, min=low, max=high, description="tilt [°]", **_SLIM)
        for name, one in (("pan", self.pan), ("tilt", self.tilt)):
            one.observe(lambda change, name=name: self._aimed(name, change["new"]), names="value")

    def _button(self, words: str, icon: str, style: str) -> w.Button:
        return w.Button(description=words, icon=icon, button_style=style, layout=_grown())

    def _laid_out(self) -> w.VBox:
        self.manual.layout = w.Layout(flex="1 0 9.5em", width="auto")
        self.keys.layout = w.Layout(flex="2 1 9em", width="auto", min_width="0")
        rows = (
            (self.start, self.stop, self.retry),
            (self.colour, self.side),
            (self.manual, self.keys),
        )
        lines = [w.HBox(row, layout=w.Layout(width="100%", flex_flow="row wrap")) for row in rows]
        self.release.layout = w.Layout(flex="0 1 7em", width="auto", min_width="6em")
        gripper = w.HBox([self.intake, self.release], layout=w.Layout(width="100%"))
        all_of_it = [*lines, *self.sliders, gripper, self.pan, self.tilt]
        return w.VBox(all_of_it, layout=w.Layout(width="100%", min_width="0", overflow="hidden"))

    # --- telling ------------------------------------------------------------------------------

    def _tell(self, name: str, value: str | float = "") -> None:
        self._inbox.tell("/operator", messages.Button(name, value))

    def _pressed_start(self, _: Any) -> None:
        """What is chosen is told first: whoever listens may have come later than the choice."""
        self._tell("colour", self.colour.value)
        self._tell("side", self.side.value)
        self._tell("start")
        self.refresh()

    def _pressed_stop(self, _: Any) -> None:
        self._tell("stop")
        self._push((0.0, 0.0, 0.0))
        self.refresh()

    def _pressed_release(self, _: Any) -> None:
        """Rollers that turn would fight the arm."""
        self.intake.value = 0.0
        self._tell("release")

    def _took_over(self, change: Any) -> None:
        """Whoever takes over has what the screen shows: rollers that stand, the camera there."""
        self._push((0.0, 0.0, 0.0))
        self._tell("manual", "on" if change["new"] else "off")
        self.intake.value = 0.0
        if change["new"]:
            self._aimed("pan", self.pan.value)
            self._aimed("tilt", self.tilt.value)
        else:
            self._inbox.tell("/cmd_vel", messages.Twist(0.0, 0.0, 0.0))
        self.refresh()

    def _chose(self, name: str, value: str) -> None:
        if not self._quiet:
            self._tell(name, value)

    def _follow_crew(self) -> None:
        """Show the team that was set up, and its half; who was stopped is not driven by hand."""
        if self.manual.value and not self._inbox.manual:
            self.manual.value = False
        if self._inbox.side in dict(self.side.options):
            with self._silent():
                self.side.value = self._inbox.side
        told = self._inbox.set_up
        if told is not self._followed:
            self._followed, team = told, str(told.value).partition(" ")[0]
            if team in dict(self.colour.options):
                with self._silent():
                    self.colour.value = team

    def _aimed(self, name: str, angle: int) -> None:
        if self.manual.value:
            self._tell(name, radians(angle))

    def _follow_camera(self) -> None:
        """While the robot aims its camera itself, the sliders show where."""
        command = self._inbox.latest.get("/command")
        for name, slider in (("pan", self.pan), ("tilt", self.tilt)):
            angle = getattr(command, name, 0.0)
            if isinstance(angle, int | float) and abs(angle) < 10.0:  # NaN is none
                slider.value = min(max(round(degrees(angle)), slider.min), slider.max)

    # --- the stick ----------------------------------------------------------------------------

    def _steer(self) -> None:
        speeds = (float(slider.value) for slider in self.sliders)
        self._inbox.tell("/cmd_vel", messages.Twist(*speeds))

    def _moved(self, _: Any) -> None:
        self._touched = self._clock()
        if self.manual.value and not self._quiet:
            self._steer()

    def _push(self, twist: tuple[float, float, float]) -> None:
        """Move all three sliders, and tell it once."""
        with self._silent():
            for slider, speed in zip(self.sliders, twist, strict=True):
                slider.value = speed
        self._moved(None)

    @contextmanager
    def _silent(self) -> Any:
        self._quiet = True
        try:
            yield
        finally:
            self._quiet = False

    def _typed(self, change: Any) -> None:
        share = KEYS.get(change["new"][-1:].lower())
        if share is None or not self.manual.value:
            return
        self._held = self._clock()
        vx, vy, omega = (part * end for part, end in zip(share, LIMITS, strict=True))
        self._push((vx, vy, omega))

    def _plugged(self, change: Any) -> None:
        for axis in change["new"]:
            axis.observe(self._stick_moved, names="value")

    def _stick_moved(self, _: Any) -> None:
        if self.manual.value:
            self._push(pushed([axis.value for axis in self.pad.axes]))

    def _let_go(self, connected: bool) -> None:
        """Back to the middle where a key was let go, nobody touches, or no robot hears."""
        now = self._clock()
        released = self._held is not None and now - self._held > HELD
        if released:
            self._held, self.keys.value = None, ""
        if released or not connected or now - self._touched > PATIENCE:
            with self._silent():
                for slider in self.sliders:
                    slider.value = 0.0


_SLIM = {"style": {"description_width": "4.5em"}, "layout": w.Layout(width="auto")}


def _grown() -> w.Layout:
    return w.Layout(flex="1 1 0", width="auto", min_width="5em")


def _choice(name: str, options: Any, start: str = "") -> w.ToggleButtons:
    chosen = dict(options).get(start, options[0][1])
    one = w.ToggleButtons(options=options, value=chosen, description=name)
    one.style = {"description_width": "auto", "button_width": "3.6em"}
    one.layout = w.Layout(width="auto", flex="1 1 auto")
    return one

"""Driving by hand: sliders or a gamepad, the robot on its field, in real time.

The cell shows a still picture and a button. Only the button starts a simulator; so a notebook that
runs from top to bottom waits for nothing. While the robot moves, a task in the kernel's own loop
lets time pass a tenth of a second after the other; the kernel stays free between two pictures.
"""

from __future__ import annotations

import asyncio
import html
import uuid
from typing import Any

import numpy as np

from robocon_course.autopilot import Parts
from robocon_course.simulator import Simulator
from robocon_course.simulator.machine import START
from robocon_course.view.canvas import publish, show
from robocon_course.view.field_picture import draw_field
from robocon_course.view.live import MARGIN, VIEW, Ride, photograph
from robocon_course.view.stick import LIMITS, NAMES, pushed
from robocon_course.view.widgets import has_sliders

AROUND = (-0.05, 3.95, -0.05, 3.45)
FRAME = 0.1
"""Time between two pictures [s]."""
PATIENCE = 60.0
"""How long the robot keeps driving without any new input [s]."""
HINT = "vx forward, vy to the left, ω turns left.<br>A gamepad drives too: press a button on it."


def drive(parts: Parts | None = None, *, simulator: Simulator | None = None) -> None:
    """Drive the robot by hand: a picture, and a button that starts the simulator.

    Sliders or the sticks of a gamepad say how fast. The robot's own functions turn this into
    commands for its modules.

    Parameters
    ----------
    parts : Parts, optional
        Whose swerve functions drive, for instance ``robot_parts("mixed")``; without it the
        course's.
    simulator : Simulator, optional
        Another robot or another place than the start.
    """
    parts = parts or Parts()
    pose = START if simulator is None else simulator.truth.pose
    x, y, theta = (float(number) for number in pose)
    fig = draw_field(robot=pose, window=AROUND if simulator is None else None)
    twin = (
        f"Robot 2 on the field at ({x:.2f}, {y:.2f}) m, heading {np.degrees(theta):.0f}°, "
        f"parts: {parts.label}."
    )
    if not has_sliders():
        show(fig, twin)
        print("Driving needs a notebook with ipywidgets; the figure above shows the start.")
        return
    display_id = uuid.uuid4().hex
    publish(fig, twin, display_id)
    Panel(parts, simulator, display_id).offer()


class Panel:
    """The button, and what takes the picture's place once it is pressed."""

    def __init__(self, parts: Parts, simulator: Simulator | None, display_id: str) -> None:
        import ipywidgets

        self.parts, self.simulator, self.display_id = parts, simulator, display_id
        self.ride: Ride | None = None
        self.task: asyncio.Task | None = None
        self.touched = 0.0
        self.start = ipywidgets.Button(description="Drive", icon="play", button_style="primary")
        self.start.on_click(self.open)

    def offer(self) -> None:
        """Show the button under the still picture."""
        from IPython.display import publish_display_data

        publish_display_data(
            self.start._repr_mimebundle_() | {"text/plain": "Button: Drive (starts the simulator)"}
        )

    def open(self, _: Any = None) -> None:
        """Put the live panel in the place of the still picture, and start the simulator."""
        from IPython.display import publish_display_data

        self.start.disabled = True
        panel = self._widgets()._repr_mimebundle_()
        publish_display_data(panel, transient={"display_id": self.display_id}, update=True)
        self.start.layout.display = "none"
        self._wake()

    def _widgets(self) -> Any:
        """The picture, beside it sliders and buttons, below it the readout."""
        import ipywidgets as w

        style = {"description_width": "5em"}
        self.sliders = [
            w.FloatSlider(0.0, min=-end, max=end, step=0.1, description=name, style=style)
            for name, end in zip(NAMES, LIMITS, strict=True)
        ]
        for slider in self.sliders:
            slider.layout.width = "22em"
        self.field_centric = w.Checkbox(False, description="along the map's axes", indent=False)
        self.stop = w.Button(description="Stop", icon="stop", button_style="danger")
        size = f"{VIEW[0] + MARGIN[0]}px"
        self.image = w.Image(format="png", layout=w.Layout(width=size, flex="0 0 auto"))
        self.readout = w.HTML("Starting the simulator …")
        self.pad = w.Controller(index=0)
        for control in (*self.sliders, self.field_centric):
            control.observe(self._wake, names="value")
        self.stop.on_click(self._stop)
        self.pad.observe(self._plugged, names="axes")
        side = w.VBox([*self.sliders, self.field_centric, self.stop, w.HTML(HINT)])
        above = w.HBox([self.image, side], layout=w.Layout(flex_flow="row wrap"))
        return w.VBox([above, self.readout])

    def _wake(self, _: Any = None) -> None:
        """Something was touched: drive on, if nothing drives yet."""
        loop = asyncio.get_running_loop()
        self.touched = loop.time()
        if self.task is None or self.task.done():
            self.task = loop.create_task(self._drive())

    def _stop(self, _: Any = None) -> None:
        for slider in self.sliders:
            slider.value = 0.0

    def _plugged(self, change: Any) -> None:
        for axis in change["new"]:
            axis.observe(self._sticks, names="value")

    def _sticks(self, _: Any) -> None:
        """Left stick: forward and left; right stick: turn. A gamepad counts right and down."""
        twist = pushed([axis.value for axis in self.pad.axes])
        for slider, speed in zip(self.sliders, twist, strict=True):
            slider.value = speed

    async def _drive(self) -> None:
        """Let time pass while something moves; say what goes wrong where it can be read."""
        try:
            if self.ride is None:
                self.ride = await asyncio.to_thread(self._ride)
            await self._drive_on()
        except Exception as error:  # a task's exception would vanish into a log nobody reads
            if self.ride is not None:
                self.ride.halt()
            self.readout.value = html.escape(f"{type(error).__name__}: {error}")

    def _ride(self) -> Ride:
        return Ride(self.simulator or Simulator(), self.parts)

    async def _drive_on(self) -> None:
        loop, ride, note = asyncio.get_running_loop(), self.ride, ""
        while True:
            began = loop.time()
            ride.twist = tuple(slider.value for slider in self.sliders)
            ride.field_centric = self.field_centric.value
            ride.advance(FRAME)
            self._show(note)
            if not ride.moving or self.image.comm is None:
                return
            if began - self.touched > PATIENCE:
                note = f"Stopped: no input for {PATIENCE:g} s."
                self._stop()
            await asyncio.sleep(max(0.01, FRAME - (loop.time() - began)))

    def _show(self, note: str) -> None:
        self.image.value = photograph(self.ride)
        lines = [*self.ride.readout().splitlines(), *([note] if note else [])]
        self.readout.value = "<br>".join(html.escape(line) for line in lines)

"""A match in real time in a notebook: the operator's screen, and the simulator behind it."""

from __future__ import annotations

import asyncio
import html
import uuid
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING, Any

from robocon_course import field
from robocon_course.mission import mermaid, mission_table
from robocon_course.robot import Bus
from robocon_course.robot.messages import Button
from robocon_course.view.canvas import publish, show
from robocon_course.view.driving import AROUND
from robocon_course.view.field_picture import draw_field
from robocon_course.view.widgets import has_sliders

if TYPE_CHECKING:
    from robocon_course.view.dashboard import Dashboard
    from robocon_course.worlds import Play

SLICE = 0.05
"""So much passes at a time; between two slices the kernel is free [s]."""
LAG = 0.5
"""A computer that falls back by more plays slower instead of catching up [s]."""
OFFER = "Open the operator's screen"


def operate(make: Callable[[Bus], Play], *, speed: float = 1.0) -> None:
    """A picture of the start, and a button that opens the operator's screen of a match.

    Only the button makes the match. So a notebook that runs from top to bottom waits for nothing.

    Parameters
    ----------
    make : callable
        ``make(bus) -> Play``, a match that is told on the bus, such as
        ``lambda bus: Play(seed=7, bus=bus)``.
    speed : float
        As for `play_live`.
    """
    (x, y), fig = field.START, draw_field(robot=(*field.START, 0.0), window=AROUND)
    twin = f"The robot at its start at ({x:.2f}, {y:.2f}) m; the operator's screen is not open yet."
    if not has_sliders():
        show(fig, twin)
        print("The operator's screen needs a notebook with ipywidgets.")
        return
    display_id = uuid.uuid4().hex
    publish(fig, twin, display_id)
    Offer(make, speed, display_id).show()


class Offer:
    """The button under the picture, and what it starts."""

    def __init__(self, make: Callable[[Bus], Play], speed: float, display_id: str) -> None:
        import ipywidgets as w

        self.make, self.speed, self.display_id = make, speed, display_id
        self.screen: Dashboard | None = None
        self.task: asyncio.Task | None = None
        wide = w.Layout(width="auto")
        self.button = w.Button(
            description=OFFER, icon="gamepad", button_style="primary", layout=wide
        )
        self.words = w.HTML()
        self.button.on_click(self._pressed)
        self.widget = w.VBox([self.button, self.words])

    def show(self) -> None:
        """Put the button into the notebook."""
        from IPython.display import publish_display_data

        publish_display_data(self.widget._repr_mimebundle_() | {"text/plain": f"Button: {OFFER}"})

    def _pressed(self, _: Any) -> None:
        self.button.disabled, self.words.value = True, "Starting the simulator …"
        self.task = asyncio.get_running_loop().create_task(self._open())

    async def _open(self) -> None:
        """Make the match aside, and put its screen in the place of the picture."""
        try:
            play = await asyncio.to_thread(self.make, Bus())
            self.screen = play_live(play, speed=self.speed, display_id=self.display_id)
        except Exception as error:  # a task's exception would vanish into a log nobody reads
            self.words.value = html.escape(f"{type(error).__name__}: {error}")
            self.button.disabled = False
        else:
            self.widget.layout.display = "none"


def play_live(play: Play, *, speed: float = 1.0, display_id: str | None = None) -> Dashboard:
    """Play a match in real time, with the operator's screen. Start it there.

    Parameters
    ----------
    play : Play
        Made with a bus.
    speed : float
        How many times as fast as real time, as far as the computer can.
    display_id : str, optional
        Of an output that the screen takes the place of.

    Returns
    -------
    Dashboard
        Closing it ends the match.

    Raises
    ------
    ValueError
        A play without a bus, a speed that is not positive, or no notebook around.
    """
    from robocon_course.view.dashboard import dashboard

    if not isinstance(play.bus, Bus):
        raise ValueError("play: expected one with a bus, such as Play(bus=Bus())")
    if not 0.0 < speed <= 20.0:
        raise ValueError(f"speed: expected a number above 0, at most 20, got {speed!r}")
    screen = dashboard(play.bus, states=mermaid(mission_table()), display_id=display_id)
    try:
        loop = asyncio.get_running_loop()
    except RuntimeError:
        return screen  # a plain script: whoever runs it lets time pass
    task = loop.create_task(_run(play, screen, speed))
    screen.task = task  # a task that nobody holds may be collected
    return screen


async def _run(play: Play, screen: Dashboard, speed: float) -> None:
    """Let the simulator keep pace with the clock on the wall.

    After the end the robot stands there and is heard: a silent one would look like a broken link.
    The stop is told like an operator's, so that a log of it can be replayed.
    """
    due = monotonic()
    while not screen.closed:
        for _ in range(max(1, round(SLICE * speed / 0.01))):
            play.tick()
            if play.match.over and not play.pilot.stopped:
                play.bus.publish("/operator", Button("stop"))
        due = max(due + SLICE, monotonic() - LAG)
        await asyncio.sleep(max(0.001, due - monotonic()))

"""The operator's screen: its panes, and the clock that draws them."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable
from typing import Any
from weakref import WeakKeyDictionary, ref

import ipywidgets as w

from robocon_course.robot import Bus
from robocon_course.view.dashboard import field_map
from robocon_course.view.dashboard.controls import Controls
from robocon_course.view.dashboard.inbox import Inbox
from robocon_course.view.dashboard.journal import journal, status_bar
from robocon_course.view.dashboard.markup import STYLE, head
from robocon_course.view.dashboard.readings import readings
from robocon_course.view.dashboard.sight import Sight
from robocon_course.view.dashboard.states import Diagram, ways_of
from robocon_course.view.widgets import has_sliders

FASTEST, SLOWEST = 0.05, 1.0
"""Ends of the time between two pictures [s]."""
READ = ("sensors", "mission", "state", "events")
"""Panes of the last column."""
_shown: WeakKeyDictionary[Bus, ref[Dashboard]] = WeakKeyDictionary()


def dashboard(
    bus: Bus,
    *,
    refresh: float = 0.2,
    states: str | Iterable[Iterable[str]] = (),
    clock: Callable[[], float] = time.monotonic,
    display_id: str | None = None,
) -> Dashboard:
    """Show the operator's screen for everything that is told on a bus.

    It listens to every topic and tells ``/operator`` and ``/cmd_vel``; so it does not matter who
    drives the robot there. It is drawn by a task in the kernel's own loop: whoever publishes from
    the same notebook has to leave the loop free between two steps (``await asyncio.sleep``). A
    bus has one screen: where a cell is run again, the screen before is closed, and the new one goes
    on with its log and its path.

    Parameters
    ----------
    bus : Bus
    refresh : float  [s]
        Time between two pictures, 0.05 to 1.
    states : str or iterable of (source, target, label), optional
        The mission's ways from state to state, as a list or in Mermaid's language; without them
        only names and history are shown.
    clock : callable, optional
        Wall time [s].
    display_id : str, optional
        Of an output that the screen takes the place of.

    Returns
    -------
    Dashboard
        Its ``close()`` ends it. Without a notebook nothing is shown; ``draw()`` draws by hand.

    Raises
    ------
    ValueError
        No bus, a refresh outside its range, states that are no ways.
    """
    screen = Dashboard(bus, refresh=refresh, states=states, clock=clock)
    before = _shown[bus]() if bus in _shown else None
    if before is not None:
        before.close()
        screen.inbox.inherit(before.inbox)
    _shown[bus] = ref(screen)
    screen.draw()
    if has_sliders():
        screen.show(display_id)
    return screen


class Dashboard:
    """The operator's screen as a widget; `dashboard` makes and shows one.

    Parameters
    ----------
    bus : Bus
    refresh : float  [s]
    states : str or iterable of (source, target, label)
    clock : callable
        Wall time [s].

    Attributes
    ----------
    inbox : Inbox
        What was heard.
    controls : Controls
        What can be touched.
    panes : dict of HTML widgets
        ``"status"``, ``"map"``, ``"where"``, ``"camera"``, ``"sensors"``, ``"mission"``,
        ``"state"`` and ``"events"``.
    failures : dict
        Pane and exception of what could not be drawn the last time.
    widget : VBox
        The whole screen.
    closed : bool
    """

    def __init__(
        self,
        bus: Bus,
        *,
        refresh: float = 0.2,
        states: str | Iterable[Iterable[str]] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if not isinstance(bus, Bus):
            raise ValueError(f"bus: expected a Bus, got {type(bus).__name__}")
        if not isinstance(refresh, int | float) or not FASTEST <= refresh <= SLOWEST:
            raise ValueError(
                f"refresh: expected seconds from {FASTEST:g} to {SLOWEST:g}, got {refresh!r}"
            )
        diagram = Diagram(ways_of(states))
        self.refresh = float(refresh)
        self.inbox = Inbox(bus, clock)
        self.controls = Controls(self.inbox, clock)
        self.failures: dict[str, Exception] = {}
        self.closed = False
        self._task: asyncio.Task | None = None
        self._painters: dict[str, Callable[[Inbox], str]] = {
            "map": field_map.overlay,
            "where": lambda inbox: field_map.where(inbox) + field_map.key(),
            "camera": Sight().draw,
            "sensors": readings,
            "mission": diagram.draw,
            "state": diagram.words,
            "events": journal,
        }
        self.panes = {name: w.HTML() for name in ("status", *self._painters)}
        self.widget = self._laid_out()

    def draw(self) -> None:
        """Draw everything that was heard. What cannot be drawn is told in the status bar."""
        if self.closed:
            return
        self.failures = {}
        for name, paint in self._painters.items():
            self._attempt(name, lambda name=name, paint=paint: self._paint(name, paint))
        self._attempt("controls", self.controls.refresh)
        self._attempt("status", self._paint_status)

    def show(self, display_id: str | None = None) -> None:
        """Put the screen into the notebook, and draw it again and again.

        Parameters
        ----------
        display_id : str, optional
            Of an output that the screen takes the place of.
        """
        from IPython.display import publish_display_data

        words = {"text/plain": "Dashboard: status, map, camera, controls, sensors, mission, events"}
        data = self.widget._repr_mimebundle_() | words
        instead = {"transient": {"display_id": display_id}, "update": True} if display_id else {}
        publish_display_data(data, **instead)
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # nobody's loop runs: whoever holds the dashboard draws it
            return
        self._task = loop.create_task(self._draw_on())

    def close(self) -> None:
        """Stand still, listen no longer, and go from the page."""
        if self.closed:
            return
        self.controls.close()
        self.closed = True
        self.inbox.close()
        self.widget.close()

    async def _draw_on(self) -> None:
        loop = asyncio.get_running_loop()
        while not self.closed and self.widget.comm is not None:
            began = loop.time()
            self.draw()
            await asyncio.sleep(max(0.01, self.refresh - (loop.time() - began)))
        self.close()

    def _attempt(self, name: str, act: Callable[[], None]) -> None:
        try:
            act()
        except Exception as error:  # one bad message leaves the other panes alone
            self.failures[name] = error

    def _paint(self, name: str, paint: Callable[[Inbox], str]) -> None:
        self.panes[name].value = paint(self.inbox)

    def _paint_status(self) -> None:
        bar = status_bar(self.inbox, self.controls.manual.value, self.failures)
        self.panes["status"].value = bar

    def _laid_out(self) -> w.VBox:
        """Three columns that wrap where the page is narrow."""
        panes = self.panes
        ground = w.HTML(field_map.floor())
        for layer in (ground, panes["map"]):
            layer.layout = w.Layout(grid_area="1 / 1 / 2 / 2", margin="0", width="100%")
        field = w.GridBox([ground, panes["map"]], layout=w.Layout(width="auto", margin="0 2px"))
        panes["events"].layout = w.Layout(flex="1 1 0", min_height="108px", overflow="hidden")
        panes["events"].add_class("rc-events")
        columns = [
            _column("4 1 270px", "335px", field, panes["where"]),
            _column("1 1 300px", "400px", panes["camera"], w.HTML(head("Controls")), self.controls),
            _column("1 1 340px", "none", *(panes[name] for name in READ)),
        ]
        row = w.HBox(columns, layout=w.Layout(flex_flow="row wrap", width="100%", grid_gap="12px"))
        screen = w.VBox([w.HTML(STYLE), panes["status"], row])
        screen.add_class("robocon-dash")
        return screen


def _column(flex: str, widest: str, *parts: Any) -> w.VBox:
    children = [getattr(part, "widget", part) for part in parts]
    layout = w.Layout(flex=flex, max_width=widest, min_width="0", overflow="hidden")
    return w.VBox(children, layout=layout)

"""What the autopilot and its robot tell on the bus, tick by tick."""

from __future__ import annotations

import numpy as np

from robocon_course.autopilot.autopilot import Autopilot
from robocon_course.robot import LIDARS, SATURATED, WEAKEST, Bus, Command, Observation
from robocon_course.robot.messages import (
    Detection2DArray,
    Image,
    LaserScan,
    Log,
    Path,
    PoseStamped,
    Silos,
    State,
)
from robocon_course.vision import CLASSES

SLOW = 0.05
"""What changes little is told so often [s]."""
ANGLES = np.array([mount.angle for mount in LIDARS])


class Telemetry:
    """Tells a bus what happens.

    Parameters
    ----------
    bus : Bus
    pilot : Autopilot
    """

    def __init__(self, bus: Bus, pilot: Autopilot) -> None:
        self.bus, self.pilot = bus, pilot
        self._next, self._said, self._plan, self._silos = -np.inf, 0, None, None
        self._steps = self._frames = -1

    def tell(self, seen: Observation, command: Command) -> None:
        """After a tick of the autopilot.

        Parameters
        ----------
        seen : Observation
        command : Command
        """
        bus, pilot, now = self.bus, self.pilot, float(seen.time)
        bus.publish("/observation", seen)
        bus.publish("/command", command)
        if pilot.history.since != self._steps:
            self._steps = pilot.history.since
            steps = pilot.history.steps
            reason = steps[-1].reason if steps else ""
            bus.publish("/mission/state", State(now, str(pilot.state), reason))
        if pilot.spoken > self._said:
            for time, level, text in pilot.speaks[self._said - pilot.spoken :]:
                bus.publish("/rosout", Log(time, level, text))
            self._said = pilot.spoken
        if pilot.driver.plan is not self._plan:
            self._plan = pilot.driver.plan
            bus.publish("/plan", Path(now, pilot.driver.plan))
        if pilot.sight.frames != self._frames:
            self._frames = pilot.sight.frames
            self._tell_picture(seen)
        if now >= self._next:
            self._next = now + SLOW
            bus.publish("/odom", PoseStamped(now, pilot.pose.copy()))
            ranges = [r.distance if WEAKEST <= r.strength < SATURATED else 0.0 for r in seen.lidar]
            bus.publish("/scan", LaserScan(now, ANGLES, np.array(ranges)))
            silos = tuple(pilot.sight.silos)
            if silos != self._silos:
                self._silos = silos
                bus.publish("/silos", Silos(now, silos))

    def _tell_picture(self, seen: Observation) -> None:
        """The last picture, and what was found in it."""
        if seen.frame is None or self.pilot.sight.found is None:
            return
        kind, found = self.pilot.sight.found
        if seen.frame.image_bgr is not None:
            self.bus.publish("/camera/image", Image(seen.frame.time, seen.frame.image_bgr))
        labels = tuple(CLASSES[kind][number] for number in found.class_ids)
        self.bus.publish(
            "/camera/detections",
            Detection2DArray(seen.frame.time, kind, found.boxes, found.scores, labels),
        )

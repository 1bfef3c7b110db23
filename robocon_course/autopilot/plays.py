"""What the robot does in each state of its mission: where to, how fast, looking at what.

Each play is a function from the autopilot to an `Order`. It may read everything the autopilot
believes; what it changes is its own notes, which `RESETS` clears when a state is entered.
"""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, inf, pi, remainder, sin
from typing import TYPE_CHECKING, NamedTuple

from robocon_course import field
from robocon_course.autopilot.driver import DRIVES, SOUTH
from robocon_course.autopilot.route import DriveLimits
from robocon_course.autopilot.taking import WALL, end_of, fits, may_pull
from robocon_course.mission import Approach, State, is_full
from robocon_course.robot import SIDE

if TYPE_CHECKING:
    from robocon_course.autopilot.autopilot import Autopilot

VIEW_POST = (2.75, 10.0, pi)
"""In the middle of the slope, looking at the pile [m, m, rad; map]."""
SILO_X = 4.75
"""From here all five silos are looked at on the way [m]."""
BEFORE_SILO, AT_SILO = 5.15, 5.50
"""Robot's middle before a silo and when it lets go [m]; its arm reaches half a metre ahead."""
IN_FRAME = 5.2
"""Nearer than this a silo is too large for the camera [m]."""
BACK = 0.45
"""So far it goes back from balls [m]."""
FRONT = 0.33
"""From the robot's middle to what its front pushes [m]."""
PUSH_TO = 1.45
"""So far it goes into the pile [m]."""
BALL_TILT, NEAR_TILT, SILO_TILT = 0.42, 0.70, 0.05
"""Of the camera [rad]."""
MIDST = (1.2, 9.9)
"""Of where balls lie [m, map]."""
WIDE = 1.3
"""So far the camera turns to either side [rad]."""
PANS = (0.75, -0.75, 0.0)
"""Where it looks in turn for balls [rad]."""
LOOK_FOR = 0.45
"""So long in each direction [s]."""
GLANCE = 2.5
"""After so long the silos are taken as they are believed [s]."""
SETTLES, ON_AVERAGE = 0.4, 1.5
"""A turn takes so much longer than at its full rate [s]; speed on a short way [m/s]."""
ACROSS = DriveLimits(2.0, 2.0, 1.5, 2.5)
FAST = DriveLimits(3.0, 4.0, 1.5, 2.5)
TAKING = DriveLimits(0.8, 3.0, 1.0, 2.5)
PUSHING = DriveLimits(0.9, 2.0, 1.0, 2.5)
STORING = DriveLimits(0.9, 2.0, 1.0, 2.5)
"""Over the ramps; in Area 3; to a ball; into the pile; to a silo. The source's robot takes 0.25 m/s
to a ball, 0.45 to a silo and 0.9 into the pile."""


class Order(NamedTuple):
    """What to do until the next look.

    Attributes
    ----------
    target : tuple of 3 floats or None  [m, m, rad; map]
        Where to; None: stand.
    limits : DriveLimits
    intake : float
    release : bool
    pan, tilt : float  [rad]
    watch : str
        ``"ball"``, ``"silo"`` or nothing.
    """

    target: tuple[float, float, float] | None = None
    limits: DriveLimits = FAST
    intake: float = 0.0
    release: bool = False
    pan: float = 0.0
    tilt: float = BALL_TILT
    watch: str = ""


def _stand(pilot: Autopilot) -> Order:
    return Order()


def _to_area_3(pilot: Autopilot) -> Order:
    return Order((*field.AREA_3_GOAL, 0.0), ACROSS)


def _look_for_balls(pilot: Autopilot) -> Order:
    return Order(watch="ball")


def _search_balls(pilot: Autopilot) -> Order:
    """At the balls' midst on the way to where all are seen, and from there all around."""
    if "there" not in pilot.notes and not pilot.near(VIEW_POST, 0.3, 0.3):
        return _looking_at_balls(pilot)
    step = int((pilot.now - pilot.notes.setdefault("there", pilot.now)) / LOOK_FOR)
    pilot.notes["looked"] = step >= len(PANS)
    return Order(VIEW_POST, pan=PANS[min(step, len(PANS) - 1)], tilt=0.3, watch="ball")


def _push(pilot: Autopilot) -> Order:
    """Straight at a ball of ours among the others, each time at the next from south to north."""
    if "push" not in pilot.notes:
        balls = pilot.sight.balls
        among = [ball for ball in balls if ball.colour == pilot.team] or balls
        x, y = PUSH_TO, field.PILE_TARGET[1]
        if among:
            ball = sorted(among, key=lambda one: one.y)[pilot.pushes % len(among)]
            x, y = ball.x + FRONT, ball.y
        reach = 0.5 * SIDE + WALL
        y = min(max(y, SOUTH + reach), field.SIZE - reach)
        pilot.notes["push"] = (max(x, reach), y, pi)
    return Order(pilot.notes["push"], PUSHING)


def _reverse(pilot: Autopilot) -> Order:
    """Straight back from where it stands, to see what lies before it."""
    x, y, theta = pilot.notes.setdefault("from", tuple(pilot.pose))
    back = (x - BACK * cos(theta), y - BACK * sin(theta), theta)
    return Order(back if fits(*back) else VIEW_POST, tilt=BALL_TILT)


def _take(pilot: Autopilot) -> Order:
    way = pilot.notes.get("approach")
    if way is None:
        return Order(watch="ball")
    if not pilot.notes.get("straight"):
        pilot.notes["straight"] = pilot.near((*way.ready, way.heading), 0.07, 0.09)
        return Order((*way.ready, way.heading), _rolling(pilot, way), watch="ball")
    end = end_of(way)
    # The rollers take whatever comes: they turn only for the last bit of the way.
    close = pilot.near((*way.take, way.heading), 0.14, inf)
    pilot.notes["close"] = close or bool(pilot.notes.get("close"))
    intake = float(pilot.notes["close"] and may_pull(way, pilot))
    return Order((*end, way.heading), TAKING, intake=intake, tilt=NEAR_TILT, watch="ball")


def _rolling(pilot: Autopilot, way: Approach) -> DriveLimits:
    """Through the place before a ball without a stop, if the robot can turn to it on the way."""
    x, y, theta = pilot.pose
    far = hypot(way.ready[0] - x, way.ready[1] - y)
    turns = abs(remainder(way.heading - theta, 2 * pi)) / DRIVES.spin + SETTLES
    return FAST._replace(arrive=TAKING.speed if far > turns * ON_AVERAGE else 0.0)


def _search_silo(pilot: Autopilot) -> Order:
    """The camera turns to the silos before the robot does, then to those it has not seen yet."""
    x, y, theta = (float(number) for number in pilot.pose)
    seen = [time > pilot.history.since for time in pilot.sight.seen_silos]
    settled = x > 2.5 and (all(seen) or x > SILO_X - 0.3 or pilot.waited > GLANCE)
    if settled and abs(remainder(theta, 2 * pi)) < 0.5:
        _choose(pilot)
    missing = [silo for silo, fresh in zip(field.SILOS, seen, strict=True) if not fresh]
    at = missing[0] if missing and x > 3.6 else field.SILOS[len(field.SILOS) // 2]
    pan, in_view = _aimed(pilot, at)
    target = SILO_X, min(max(y, 9.4), 10.6), 0.0
    return Order(target, tilt=SILO_TILT, pan=pan, watch="silo" if in_view else "")


def _choose(pilot: Autopilot) -> None:
    if all(map(is_full, pilot.sight.silos)):  # a robot with a ball may wait like this for a minute
        return
    silo = pilot.parts.choose_silo(
        pilot.sight.silos, pilot.team, float(pilot.pose[1]), pilot.rhythm
    )
    if silo is not None:
        pilot.notes["silo"] = int(silo)
        pilot.notes["silos"] = list(pilot.sight.silos)


def _approach(pilot: Autopilot) -> Order:
    if not pilot.notes.get("before") and pilot.notes.get("silos") != pilot.sight.silos:
        _choose(pilot)  # somebody was here since: perhaps another one is better now
    silo = pilot.notes.get("silo")
    if silo is None:
        return Order()
    y = field.SILOS[silo][1]
    pilot.notes["full"] = is_full(pilot.sight.silos[silo])
    before = (BEFORE_SILO, y, 0.0)
    watch = "silo" if pilot.pose[0] < IN_FRAME else ""
    if not pilot.notes.get("before"):
        pilot.notes["before"] = pilot.near(before, 0.06, 0.06)
        return Order(before, FAST._replace(arrive=STORING.speed), tilt=SILO_TILT, watch=watch)
    at = (AT_SILO, y, 0.0)
    if pilot.near(at, 0.03, 0.03) and pilot.speed < 0.2:  # it stands before the ball falls
        pilot.notes["let go"] = True
    release = bool(pilot.notes.get("let go"))
    return Order(at, STORING, tilt=SILO_TILT, release=release, watch=watch)


def _leave_silo(pilot: Autopilot) -> Order:
    """Straight back to where the robot may turn, measuring the walls on the way."""
    x, y, theta = pilot.pose
    start = pilot.notes.setdefault("from", (float(x), float(y), float(theta)))
    return Order((BEFORE_SILO - 0.05, start[1], start[2]), tilt=SILO_TILT, watch="silo")


def _silo_full(pilot: Autopilot) -> Order:
    start = pilot.notes.setdefault("from", tuple(pilot.pose))
    return Order((4.9, start[1], 0.0), tilt=SILO_TILT, watch="silo")


def _looking_at_balls(pilot: Autopilot) -> Order:
    """To where all balls are seen; the camera turns to them before the robot does."""
    pan, in_view = _aimed(pilot, MIDST)
    return Order(VIEW_POST, pan=pan, tilt=0.3, watch="ball" if in_view else "")


def _aimed(pilot: Autopilot, place: tuple[float, float]) -> tuple[float, bool]:
    """How far the camera turns towards a place [rad], and whether it can look there at all."""
    x, y, theta = pilot.pose
    pan = remainder(atan2(place[1] - y, place[0] - x) - theta, 2 * pi)
    return min(max(pan, -WIDE), WIDE), abs(pan) < WIDE


def _free(pilot: Autopilot) -> Order:
    """Stuck: back the way it came, a little."""
    if "from" not in pilot.notes:
        x, y, theta = (float(number) for number in pilot.pose)
        vx, vy = pilot.driver.ordered
        speed = hypot(vx, vy)
        away = (-vx / speed, -vy / speed) if speed > 0.01 else (-cos(theta), -sin(theta))
        pilot.notes["from"] = (x + 0.3 * away[0], y + 0.3 * away[1], theta)
    return Order(pilot.notes["from"], STORING)


PLAYS: dict[State, Callable[[Autopilot], Order]] = {
    State.RESET: _stand,
    State.GO_TO_AREA_3: _to_area_3,
    State.LIDAR_RESET: _stand,
    State.DETECT_BALL: _look_for_balls,
    State.SEARCH_BALL: _search_balls,
    State.PUSH_PILE: _push,
    State.REVERSE: _reverse,
    State.TAKE_BALL: _take,
    State.SEARCH_SILO: _search_silo,
    State.APPROACH_SILO: _approach,
    State.SILO_FULL: _silo_full,
    State.RESET_AFTER_SILO: _leave_silo,
    State.BACK_TO_STORAGE: _looking_at_balls,
    State.STUCK: _free,
    State.NO_SENSORS: _stand,
    State.FINISHED: _stand,
}

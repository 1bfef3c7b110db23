"""Which ball to take and from where, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import atan2, hypot, inf, pi, remainder
from typing import Any

import numpy as np

from robocon_course import mission
from robocon_course.exercises.compare import kind_of
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.mission import Approach, Room, SeenBall
from robocon_course.mission.balls import DIRECTIONS, TURN_WEIGHT
from robocon_course.worlds import Student
from robocon_course.worlds.missions import STORAGE, some_balls

Fits = Callable[[float, float, float], bool]
LONELY = SeenBall(1.8, 10.0, "red")
STEP = 2 * pi / DIRECTIONS


def _price(way: Approach, pose: Sequence[float]) -> float:
    turn = abs(remainder(way.heading - pose[2], 2 * pi))
    return hypot(way.ready[0] - pose[0], way.ready[1] - pose[1]) + TURN_WEIGHT * turn


def _both_fit(way: Approach, fits: Fits) -> bool:
    return fits(*way.ready, way.heading) and fits(*way.take, way.heading)


def _chosen(
    *,
    own: Callable[[SeenBall, str], bool] = lambda ball, team: ball.colour == team,
    price: Callable[[Approach, Sequence[float]], float] = _price,
    clear: Callable[[Approach, Sequence[SeenBall], str], bool] = (
        lambda way, balls, team: mission.is_clear(way, balls)
    ),
    fits_in: Callable[[Approach, Fits], bool] = _both_fit,
    angles: Callable[[float], list[float]] = lambda straight: (
        [straight + (k + 1) // 2 * STEP * (1 if k % 2 else -1) for k in range(DIRECTIONS)]
    ),
    shown: Callable[[Approach], Any] = lambda way: way,
    most: bool = False,
) -> Callable[..., Any]:
    """The choice with one part wrong."""

    def function(balls: Sequence[SeenBall], team: str, pose: Sequence[float], fits: Fits) -> Any:
        best, least = None, inf
        for ball in balls:
            if not own(ball, team):
                continue
            for heading in angles(atan2(ball.y - pose[1], ball.x - pose[0])):
                way = mission.approach_from(ball, heading)
                cost = -price(way, pose) if most else price(way, pose)
                if cost < least and clear(way, balls, team) and fits_in(way, fits):
                    best, least = way, cost
        return None if best is None else shown(best)

    return function


def _nearest_first(
    balls: Sequence[SeenBall], team: str, pose: Sequence[float], fits: Fits
) -> Approach | None:
    """The nearest own ball, even if it cannot be come at."""
    mine = [ball for ball in balls if ball.colour == team]
    if not mine:
        return None
    near = min(mine, key=lambda ball: hypot(ball.x - pose[0], ball.y - pose[1]))
    others = [near, *(ball._replace(colour="purple") for ball in balls if ball is not near)]
    return _chosen()(others, team, pose, fits)


def _first_way(
    balls: Sequence[SeenBall], team: str, pose: Sequence[float], fits: Fits
) -> Approach | None:
    """The first way that is possible, not the cheapest."""
    for ball in balls:
        found = _chosen()([ball, *(b._replace(colour="purple") for b in balls if b is not ball)],
                          team, pose, fits) if ball.colour == team else None  # fmt: skip
        if found is not None:
            return found
    return None


def _no_turn(way: Approach, pose: Sequence[float]) -> float:
    return hypot(way.ready[0] - pose[0], way.ready[1] - pose[1])


def _not_wrapped(way: Approach, pose: Sequence[float]) -> float:
    return _no_turn(way, pose) + TURN_WEIGHT * abs(way.heading - pose[2])


def _to_the_ball(way: Approach, pose: Sequence[float]) -> float:
    turn = abs(remainder(way.heading - pose[2], 2 * pi))
    return hypot(way.ball.x - pose[0], way.ball.y - pose[1]) + TURN_WEIGHT * turn


def _whole_turn(way: Approach, pose: Sequence[float]) -> float:
    return _no_turn(way, pose) + abs(remainder(way.heading - pose[2], 2 * pi))


WRONG: dict[str, tuple[str, Callable[..., Any]]] = {
    "any colour": (
        "Balls of any colour are taken. Another team's ball in the gripper is a foul: compare "
        "ball.colour with team.",
        _chosen(own=lambda ball, team: True),
    ),
    "not the purple ones": (
        "Every ball but a purple one is taken, the other team's too. Only ball.colour == team is "
        "yours.",
        _chosen(own=lambda ball, team: ball.colour != "purple"),
    ),
    "always red": (
        "Red balls are taken for both teams. Ask team.",
        _chosen(own=lambda ball, team: ball.colour == "red"),
    ),
    "other balls not minded": (
        "Another ball lies on the way of the rollers, and would be taken first. Ask "
        "mission.is_clear(way, balls).",
        _chosen(clear=lambda way, balls, team: True),
    ),
    "own balls hidden from is_clear": (
        "Own balls on the way do not matter here. But they do: the rollers would push them, or "
        "take two. Give is_clear all balls.",
        _chosen(
            clear=lambda way, balls, team: mission.is_clear(
                way, [b for b in balls if b is way.ball or b.colour != team]
            )
        ),
    ),
    "walls not minded": (
        "The robot would stand in a wall. Ask fits(x, y, heading) for both places, way.ready and "
        "way.take.",
        _chosen(fits_in=lambda way, fits: True),
    ),
    "only the last place fits": (
        "At way.take the robot fits, at way.ready it does not. Ask for both.",
        _chosen(fits_in=lambda way, fits: fits(*way.take, way.heading)),
    ),
    "only the first place fits": (
        "At way.ready the robot fits, at way.take it does not. Ask for both.",
        _chosen(fits_in=lambda way, fits: fits(*way.ready, way.heading)),
    ),
    "only straight ahead": (
        "Balls are taken straight ahead only. From another direction the way may be free.",
        _chosen(angles=lambda straight: [straight]),
    ),
    "turning costs nothing": (
        "The turn is left out of the price: 0.25 m for each radian from the robot's heading.",
        _chosen(price=_no_turn),
    ),
    "turn not wrapped": (
        "The turn is not wrapped: from 179° to −179° it is 2°, not 358°. Use geometry.wrap_angle.",
        _chosen(price=_not_wrapped),
    ),
    "a radian for a metre": (
        "A radian of turning counts like a metre. It is worth 0.25 m.",
        _chosen(price=_whole_turn),
    ),
    "way to the ball": (
        "The way is measured to the ball. The robot first drives to way.ready.",
        _chosen(price=_to_the_ball),
    ),
    "the dearest": (
        "This takes the way with the highest price.",
        _chosen(most=True),
    ),
    "the nearest ball or none": (
        "Only the nearest own ball is looked at. If nobody can come at it another one may do.",
        _nearest_first,
    ),
    "the first ball that can be had": (
        "The first own ball that can be come at is taken. Another one may be cheaper: compare all.",
        _first_way,
    ),
}


def _told(way: Any) -> Any:
    """Ball and direction: by what one way is told from another."""
    if type(way).__name__ != "Approach":
        return repr(way)[:40]
    return way.ball.x, way.ball.y, round(remainder(float(way.heading), 2 * pi), 4)


TIGHT = STORAGE._replace(x1=3.3, y1=10.7)
"""There the robot often fits at one of the two places only."""
IN_TIGHT = ("only the last place fits", "only the first place fits", "walls not minded")


def _situation(
    rng: np.random.Generator, wrong: Callable[..., Any], team: str, room: Room = STORAGE
) -> tuple:
    """Balls and a pose where a wrong choice, and none by chance, is another one."""
    while True:
        balls = some_balls(rng, int(rng.integers(5, 11)) if room is STORAGE else 3)
        pose = np.round([rng.uniform(1.0, 4.0), rng.uniform(9.0, 11.0), rng.uniform(-3.1, 3.1)], 3)
        right = mission.choose_ball(balls, team, pose, room)
        if right is None:
            continue
        other = wrong(balls, team, pose, room)
        apart = other is None or _told(other) != _told(right)
        if apart and _margin(right, (balls, team, pose, room)) > 1e-3:
            return balls, team, pose, room


def _margin(best: Approach, args: tuple) -> float:
    """By how much the second best way is dearer."""

    def price(way: Approach, pose: Sequence[float]) -> float:
        return inf if _told(way) == _told(best) else _price(way, pose)

    second = _chosen(price=price)(*args)
    return inf if second is None else _price(second, args[2]) - _price(best, args[2])


def _case(what: str, args: tuple) -> Case:
    expected = mission.choose_ball(*args)

    def judge(reply: Any) -> str | None:
        if reply.error:
            return f"{reply.error}: {reply.message}"
        came = reply.value
        if came is not None and type(came).__name__ != "Approach":
            form = "expected a mission.Approach, as mission.approach_from makes it"
            return f"{form}, got {kind_of(came)}"
        if came is None or expected is None:
            told = "None: no own ball can be come at" if expected is None else _words(expected)
            return None if came is expected else f"expected {told}, got {_words(came)}"
        same = _told(came) == _told(expected)
        return None if same else f"expected {_words(expected)}, got {_words(came)}"

    return Case(what, args, judge=judge, traits=_told)


def _words(way: Approach | None) -> str:
    if way is None:
        return "None"
    degrees = np.degrees(remainder(float(way.heading), 2 * pi))
    return (
        f"the {way.ball.colour} ball at ({way.ball.x:.2f}, {way.ball.y:.2f}) with heading "
        f"{degrees:.0f}°"
    )


def _cases(student: Student, rng: np.random.Generator) -> list[Case]:
    pose = np.round([rng.uniform(3.2, 3.9), rng.uniform(9.6, 10.4), rng.uniform(2.6, 3.1)], 3)
    corner = [SeenBall(0.45, 8.35, "red")]
    rows = [
        ("no balls", ([], "red", pose, STORAGE)),
        ("one own ball", ([LONELY], "red", pose, STORAGE)),
        ("no ball of the own colour", ([LONELY], "blue", pose, STORAGE)),
        ("an own ball in a corner, where the robot does not fit", (corner, "red", pose, STORAGE)),
    ]
    for name, (_, wrong) in WRONG.items():
        team = "blue" if name == "always red" else ("red", "blue")[int(rng.integers(2))]
        room = TIGHT if name in IN_TIGHT else STORAGE
        rows.append(("balls of your own", _situation(rng, wrong, team, room)))
    return [_case(*row) for row in rows]


CHOOSE_BALL = Exercise(
    id="mission.choose_ball",
    title="Which ball, and from where",
    points=4,
    reference=mission.choose_ball,
    cases=_cases,
    time_limit=10.0,
    hints=(
        "Three loops in one another: over the balls of the own colour, over the 32 directions "
        "(2π/32 apart, beginning with the one straight from the robot to the ball), and none for "
        "the rest: mission.approach_from(ball, heading) makes the way.",
        "Its price: the distance from the robot to way.ready, plus 0.25 m for each radian between "
        "the robot's heading and way.heading. The turn has to be wrapped: geometry.wrap_angle.",
        "A way counts only if mission.is_clear(way, balls), and if the robot fits at both places: "
        "fits(*way.ready, way.heading) and fits(*way.take, way.heading). Keep the cheapest; None "
        "if there is none.",
    ),
    mistakes=tuple(Mistake(name, message, wrong) for name, (message, wrong) in WRONG.items()),
)

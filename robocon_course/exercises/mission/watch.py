"""Is the robot stuck? And how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan
from typing import Any

import numpy as np

from robocon_course import mission
from robocon_course.exercises.likeness import like_case
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.mission import Watch
from robocon_course.mission.watch import LEAST, ORDERED, WINDOW
from robocon_course.worlds import Student

Told = tuple[Watch, bool]


def _same(came: Told, expected: Told) -> Told:
    """Where nothing is remembered the place means nothing."""
    watch, stuck = came
    if watch.since == inf and expected[0].since == inf:
        watch = watch._replace(x=expected[0].x, y=expected[0].y)
    return watch, stuck


def _cases(student: Student, rng: np.random.Generator) -> list[Case]:
    x, y = np.round(rng.uniform(1.0, 4.0), 3), np.round(rng.uniform(9.0, 11.0), 3)
    began, here = float(np.round(rng.uniform(20.0, 60.0), 2)), [float(x), float(y), 0.3]
    held = Watch(began, float(x), float(y))
    beside = [x + 0.02, y - 0.02, 1.0]  # 28 mm away
    far = [x + 0.025, y - 0.025, 0.3]  # 35 mm away, but neither coordinate is
    rows = [
        ("it begins to drive", Watch(), began, here, 0.8),
        ("it begins to drive at another place", Watch(), began, beside, 0.8),
        ("for half a second it has come nowhere", held, began + 0.5, here, 0.8),
        ("for two seconds it has come nowhere", held, began + 2.0, here, 0.8),
        ("it trembles, and comes nowhere", held, began + 2.0, beside, 0.8),
        ("it turns on the spot for two seconds", held, began + 2.0, [x, y, 2.5], 0.8),
        ("it came somewhere in two seconds", held, began + 2.0, far, 0.8),
        ("it came somewhere along x", held, began + 1.0, [x - 0.1, y, 0.3], 0.8),
        ("it came somewhere along y", held, began + 2.0, [x, y + 0.2, 0.3], 0.8),
        ("it was told to stand", held, began + 2.0, here, 0.0),
        ("it was told to creep", held, began + 2.0, here, 0.05),
        ("it just became 1.5 s", held, began + 1.4, here, 0.3),
        ("a little more than 1.5 s", held, began + 1.6, here, 0.15),
        ("nobody knows where it is", held, began + 2.0, [nan, y, 0.3], 0.8),
        ("nobody knows what it was told", held, began + 2.0, here, nan),
    ]
    return [
        like_case(what, mission.is_stuck, (watch, now, np.array(pose, float), ordered), _same, 1e-9)
        for what, watch, now, pose, ordered in rows
    ]


def _stuck(
    *,
    orders: Callable[[float], bool] = lambda ordered: ordered > ORDERED,
    gap: Callable[[float, float], float] = lambda dx, dy: float(np.hypot(dx, dy)),
    stays: Callable[[float], bool] = lambda moved: moved <= LEAST,
    standing: Callable[[Watch], Told] = lambda watch: (Watch(), False),
    held: Callable[[Watch, float, float, float], Watch] = lambda watch, now, x, y: watch,
    fresh: Callable[[Watch, float, float, float], Watch] = lambda watch, now, x, y: Watch(
        now, x, y
    ),
    told: Callable[[float], bool] = lambda since: since > WINDOW,
    shown: Callable[[Watch, bool], Any] = lambda watch, stuck: (watch, stuck),
) -> Callable[..., Any]:
    """The watch with one part wrong."""

    def function(watch: Watch, now: float, pose: np.ndarray, ordered: float) -> Any:
        x, y = float(pose[0]), float(pose[1])
        if not orders(ordered):
            return shown(*standing(watch))
        if watch.since == inf or not stays(gap(x - watch.x, y - watch.y)):
            return shown(fresh(watch, now, x, y), False)
        return shown(held(watch, now, x, y), told(now - watch.since))

    return function


IS_STUCK = Exercise(
    id="mission.is_stuck",
    title="Is the robot stuck?",
    points=2,
    reference=mission.is_stuck,
    cases=_cases,
    hints=(
        "Three situations. Not told to drive faster than 0.1 m/s: forget everything, (Watch(), "
        "False).",
        "Told to drive, and nothing is remembered yet (watch.since is infinite) or it is more than "
        "0.03 m from watch.x, watch.y: remember this moment and place, Watch(now, x, y), False.",
        "Else it is where it was: keep the watch as it is, and say whether now − watch.since is "
        "more than 1.5 s.",
        "A comparison with nan is False. Write “not ordered > 0.1”, and “not moved <= 0.03”: then "
        "nan never counts as stuck.",
    ),
    mistakes=(
        Mistake(
            "standing counts as stuck",
            "A robot that was told to stand comes nowhere, and is not stuck. If ordered is not "
            "more than 0.1 m/s, return Watch(), False.",
            _stuck(orders=lambda ordered: True),
        ),
        Mistake(
            "any order counts",
            "Told to creep at 0.05 m/s it needs more than 1.5 s for 3 cm, at 0.02 m/s. Only more "
            "than 0.1 m/s counts as driving.",
            _stuck(orders=lambda ordered: ordered > 0.0),
        ),
        Mistake(
            "the place moves along",
            "The place is renewed with every look. A robot that slides a millimetre each time is "
            "then never anywhere else: keep the watch as it is.",
            _stuck(held=lambda watch, now, x, y: watch._replace(x=x, y=y)),
        ),
        Mistake(
            "the time moves along",
            "The time is renewed with every look, so 1.5 s never pass. Keep the watch as it is.",
            _stuck(held=lambda watch, now, x, y: watch._replace(since=now)),
        ),
        Mistake(
            "everything moves along",
            "Time and place are renewed with every look, so 1.5 s never pass. Keep the watch as it "
            "is while the robot is near its place.",
            _stuck(held=lambda watch, now, x, y: Watch(now, x, y)),
        ),
        Mistake(
            "each axis alone",
            "2.5 cm along x and 2.5 cm along y are 3.5 cm of way. Take the distance.",
            _stuck(gap=lambda dx, dy: max(abs(dx), abs(dy))),
        ),
        Mistake(
            "sum of the axes",
            "2 cm along x and 2 cm along y are 2.8 cm of way. Take the distance.",
            _stuck(gap=lambda dx, dy: abs(dx) + abs(dy)),
        ),
        Mistake(
            "only x",
            "Only x is looked at: a robot that drives along y seems stuck.",
            _stuck(gap=lambda dx, dy: abs(dx)),
        ),
        Mistake(
            "distance squared",
            "The squared distance is compared with 0.03 m. Take the root, or compare with 0.03².",
            _stuck(gap=lambda dx, dy: dx * dx + dy * dy),
        ),
        Mistake(
            "stuck at once",
            "Whoever starts has come nowhere, too. Only after 1.5 s it is stuck.",
            _stuck(told=lambda since: True),
        ),
        Mistake(
            "one second",
            "It says stuck after 1 s. WINDOW is 1.5 s.",
            _stuck(told=lambda since: since > 1.0),
        ),
        Mistake(
            "not started again",
            "When it came somewhere the old moment is kept. Remember the new moment and place.",
            _stuck(
                fresh=lambda watch, now, x, y: (
                    watch if np.isfinite(watch.since) else Watch(now, x, y)
                )
            ),
        ),
        Mistake(
            "remembered while standing",
            "Told to stand, the old moment is kept: after a rest of 2 s the robot is called stuck "
            "as soon as it starts. Return Watch(), False.",
            _stuck(standing=lambda watch: (watch, False)),
        ),
        Mistake(
            "only yes or no",
            "Only yes or no is returned. Return both: the new watch, and whether it is stuck.",
            _stuck(shown=lambda watch, stuck: stuck),
        ),
        Mistake(
            "nan is near",
            "A position that is nan counts as no movement. nan > 0.03 is False: ask “not moved <= "
            "0.03” instead.",
            _stuck(stays=lambda moved: not moved > LEAST),
        ),
        Mistake(
            "waits while nobody knows",
            "Where the position is nan the old watch is kept. A nan counts as another place: "
            "remember now and here, as if the robot had moved.",
            _stuck(
                fresh=lambda watch, now, x, y: watch if not np.isfinite(x + y) else Watch(now, x, y)
            ),
        ),
        Mistake(
            "forgets while nobody knows",
            "Where the position is nan everything is forgotten. A nan counts as another place: "
            "remember now and here, as if the robot had moved.",
            _stuck(
                fresh=lambda watch, now, x, y: (
                    Watch() if not np.isfinite(x + y) else Watch(now, x, y)
                )
            ),
        ),
    ),
)

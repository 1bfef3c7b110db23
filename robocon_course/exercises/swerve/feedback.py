"""From the place where the robot is to the one where it should be, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import swerve
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.swerve.commands import rotated
from robocon_course.geometry import wrap_angle
from robocon_course.worlds import Student


def _pose_feedback_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    there, behind = [1.0, 2.0, 0.5], [0.4, 2.2, 0.1]
    named = [
        ("there already", there, there, 1.0),
        ("behind the target, which stands", behind, there, 1.5),
        ("looking 20° to the other side of ±180°", [1.0, 2.0, 2.96], [1.0, 2.0, -2.97], 2.0),
        ("a robot that has turned twice", [1.0, 2.0, 4 * np.pi + 0.3], there, 1.0),
        ("4 m from the target", [5.0, 1.5, 0.5], there, 1.0),
        ("looking 2 rad too far to the left", [1.0, 2.0, 2.5], there, 2.5),
        ("behind a target that moves", behind, there, 1.5, [0.5, -0.2, 0.4]),
        ("right on a target that moves", there, there, 1.0, [1.0, 0.3, -0.7]),
    ]
    cases = [
        (what, *(np.array(a) if isinstance(a, list) else a for a in args)) for what, *args in named
    ]
    for _ in range(5):
        pose, target, velocity = rng.uniform(-3.0, 3.0, (3, 3)).round(3)
        cases.append(("anywhere", pose, target, round(rng.uniform(0.5, 4.0), 2), velocity))
    return [Case(what, tuple(args), "m/s, m/s, rad/s") for what, *args in cases]


def _feedback(
    *,
    error: Callable[[np.ndarray, np.ndarray], np.ndarray] = lambda pose, target: pose - target,
    wrapped: bool = True,
    sign: float = -1.0,
    gained: Callable[[np.ndarray, float], np.ndarray] = lambda error, gain: gain * error,
    feed: Callable[[np.ndarray, float], np.ndarray] = lambda velocity, gain: velocity,
) -> Callable[..., np.ndarray]:
    """The control law with one of its parts wrong."""

    def function(
        pose: np.ndarray,
        target: np.ndarray,
        gain: float,
        feedforward: np.ndarray = (0.0, 0.0, 0.0),
    ) -> np.ndarray:
        off = error(np.array(pose), np.array(target))
        if wrapped:
            off[2] = wrap_angle(off[2])
        return sign * gained(off, gain) + feed(np.array(feedforward), gain)

    return function


def _late_wrap(error: np.ndarray, gain: float) -> np.ndarray:
    return np.append(gain * error[:2], wrap_angle(gain * error[2]))


POSE_FEEDBACK = Exercise(
    id="swerve.pose_feedback",
    title="The velocity that leads to the target",
    points=2,
    reference=swerve.pose_feedback,
    cases=_pose_feedback_cases,
    hints=(
        "Error: pose minus target. The velocity points against it, and is the larger the farther "
        "away the target is.",
        "Wrap the error's third entry: a robot at 170° turns to −170° by 20° to the left.",
        "np.array(feedforward) − gain · error, in map axes",
    ),
    mistakes=(
        Mistake(
            "away from the target",
            "The sign is wrong: the robot runs away from its target, faster and faster.",
            _feedback(sign=1.0),
        ),
        Mistake(
            "not wrapped",
            "The heading's error is not wrapped: at ±180° the robot turns the long way round.",
            _feedback(wrapped=False),
        ),
        Mistake(
            "feed-forward ignored",
            "The target's own velocity is not used: a moving target is followed late, for ever.",
            _feedback(feed=lambda velocity, gain: 0.0 * velocity),
        ),
        Mistake(
            "feed-forward subtracted",
            "The target's own velocity is subtracted: the robot lags twice as far. Add it.",
            _feedback(feed=lambda velocity, gain: -velocity),
        ),
        Mistake(
            "feed-forward times gain",
            "The target's own velocity is multiplied by the gain. It is a velocity already.",
            _feedback(feed=lambda velocity, gain: gain * velocity),
        ),
        Mistake(
            "gain ignored",
            "The gain is not used.",
            _feedback(gained=lambda error, gain: error),
        ),
        Mistake(
            "divided by the gain",
            "The error is divided by the gain. A larger gain must be faster, not slower.",
            _feedback(gained=lambda error, gain: error / gain),
        ),
        Mistake(
            "in the robot's axes",
            "The velocity is turned into the robot's axes already. This function speaks of the "
            "map; field_to_robot comes after it.",
            lambda pose, target, gain, feedforward=(0.0, 0.0, 0.0): rotated(
                swerve.pose_feedback(pose, target, gain, feedforward), -pose[2]
            ),
        ),
        Mistake(
            "heading not corrected",
            "The heading has an error, too: the third entry is missing.",
            _feedback(gained=lambda error, gain: gain * error * [1.0, 1.0, 0.0]),
        ),
        Mistake(
            "gain for the place only",
            "The heading's error is not multiplied by the gain. All three are.",
            _feedback(gained=lambda error, gain: error * [gain, gain, 1.0]),
        ),
        Mistake(
            "all three wrapped",
            "x and y are wrapped like an angle: a target 4 m ahead seems to lie behind. Only the "
            "heading is an angle.",
            _feedback(gained=lambda error, gain: gain * wrap_angle(error)),
        ),
        Mistake(
            "wrapped after the gain",
            "The angle is wrapped after it was multiplied by the gain. Then it is a turn rate: "
            "wrap the error itself.",
            _feedback(wrapped=False, gained=_late_wrap),
        ),
        Mistake(
            "distance for error",
            "The error's sign is lost: the robot always drives the same way. Do not take absolute "
            "values.",
            _feedback(gained=lambda error, gain: gain * np.abs(error)),
        ),
    ),
)

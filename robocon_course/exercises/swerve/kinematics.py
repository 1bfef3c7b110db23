"""From the body to its modules, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import swerve
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.swerve.same_modules import modules_case
from robocon_course.robot import MODULES
from robocon_course.worlds import Student

Drive = np.ndarray


def some_drive(rng: np.random.Generator, modules: int = 4) -> Drive:
    """Modules somewhere around a centre that is not their middle, in millimetre steps [m]."""
    angle = 0.7 + 2 * np.pi / modules * (np.arange(modules) + rng.uniform(-0.2, 0.2, modules))
    radius = rng.uniform(0.2, 0.5, modules)
    around = np.column_stack([radius * np.cos(angle), 0.7 * radius * np.sin(angle)])
    return np.round(around + rng.uniform(-0.1, 0.1, 2), 3)


def some_twist(rng: np.random.Generator) -> np.ndarray:
    """A twist that uses all three of its parts."""
    return np.round(rng.uniform(0.3, 1.5, 3) * rng.choice([-1.0, 1.0], 3), 3)


def _module_targets_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    held, pivot = np.array([0.3, -0.5, 0.8, 1.2]), 1.5 * np.array([-MODULES[0, 1], MODULES[0, 0]])
    named = [
        ("straight ahead at 1 m/s", [1.0, 0.0, 0.0]),
        ("to the left at 0.5 m/s", [0.0, 0.5, 0.0]),
        ("backwards", [-0.8, 0.0, 0.0]),
        ("a left turn on the spot", [0.0, 0.0, 1.0]),
        ("ahead, and turning left", [1.0, 0.0, 2.0]),
        ("no command: the modules keep their angles", [0.0, 0.0, 0.0]),
        ("at a crawl, 2 mm/s", [0.001, -0.002, 0.0]),
        ("just above rest, 0.15 mm/s", [1.5e-4, 0.0, 0.0]),
        ("just below rest, 0.05 mm/s", [0.0, -5e-5, 0.0]),
        ("a turn about the front left module, which stands still", [-pivot[0], -pivot[1], 1.5]),
        ("the same, where rounding leaves 1e-17 m/s", [0.1645, -0.1645, 0.7]),
    ]
    cases = [(what, MODULES, np.array(twist), held) for what, twist in named]
    three = some_drive(rng, 3)
    cases.append(("a robot with three modules", three, some_twist(rng), held[:3]))
    cases += [
        (
            "another robot, any twist",
            some_drive(rng),
            some_twist(rng),
            np.round(rng.normal(size=4), 3),
        )
        for _ in range(5)
    ]
    return [modules_case(what, swerve.module_targets, *args) for what, *args in cases]


def _targets(
    *,
    place: Callable[[np.ndarray], np.ndarray] = lambda positions: positions,
    twist: Callable[..., tuple] = lambda vx, vy, omega: (vx, vy, omega),
    across: float = -1.0,
    along: float = 1.0,
    angle: Callable[[np.ndarray, np.ndarray], np.ndarray] = np.arctan2,
    speed: Callable[[np.ndarray, np.ndarray], np.ndarray] = np.hypot,
    order: Callable[[np.ndarray], np.ndarray] = lambda row: row,
    hold: str = "each",
) -> Callable[..., swerve.ModuleTargets]:
    """Inverse kinematics with one of its steps done wrongly."""

    def function(
        drive: Drive, command: np.ndarray, hold_angles: np.ndarray
    ) -> swerve.ModuleTargets:
        x, y = place(np.asarray(drive, float)).T
        vx, vy, omega = twist(*command)
        a, b = vx + across * omega * y, vy + along * omega * x
        still = np.hypot(a, b) < swerve.REST
        if hold != "each":
            still = {
                "less": np.hypot(a, b) < 1e-6,
                "crawl": np.hypot(a, b) < 0.01,
                "exact": np.hypot(a, b) == 0.0,
                "any": np.full(len(x), still.any()),
                "all": np.full(len(x), not np.any(command)),
                "no way": np.full(len(x), not np.any(command[:2])),
                "never": np.full(len(x), False),
            }[hold]
        with np.errstate(all="ignore"):
            speeds = np.where(still, 0.0, speed(a, b))
            angles = np.where(still, hold_angles, angle(b, a))
        return swerve.ModuleTargets(order(speeds), order(angles))

    return function


def _swapped(row: np.ndarray) -> np.ndarray:
    """Second and last module exchanged: front left, front right, ... instead of around."""
    return row[[0, len(row) - 1, *range(2, len(row) - 1), 1]]


MODULE_TARGETS = Exercise(
    id="swerve.module_targets",
    title="Speed and angle of each module",
    points=4,
    reference=swerve.module_targets,
    shortcuts=("robocon_course.swerve.modules.fill_targets",),
    cases=_module_targets_cases,
    hints=(
        "Each module moves with the velocity of its own place: the body's velocity, plus what the "
        "turn adds there.",
        "x, y = np.array(drive).T, then a = vx − omega · y and b = vy + omega · x for all modules "
        "at once.",
        "speeds = np.hypot(a, b), angles = np.arctan2(b, a). Where speeds < swerve.REST, np.where "
        "puts 0 and the held angle.",
    ),
    mistakes=(
        Mistake(
            "degrees",
            "The angles are in degrees. Inside the robot all angles are in radians.",
            _targets(angle=lambda b, a: np.degrees(np.arctan2(b, a))),
        ),
        Mistake(
            "sign of omega",
            "The robot turns the wrong way: a positive omega turns left, counter-clockwise.",
            _targets(twist=lambda vx, vy, omega: (vx, vy, -omega)),
        ),
        Mistake(
            "plus for minus",
            "vx + omega · y should be vx − omega · y: in a left turn the left side (y > 0) runs "
            "backwards.",
            _targets(across=1.0),
        ),
        Mistake(
            "x and y swapped",
            "The module's x and y are exchanged: vx needs omega · y, vy needs omega · x.",
            _targets(place=lambda positions: positions[:, ::-1]),
        ),
        Mistake(
            "one metre out",
            "Every module is taken to stand one metre ahead or behind and one metre aside, as the "
            "listing of one source does. Use the positions in drive.",
            _targets(place=np.sign),
        ),
        Mistake(
            "omega ignored",
            "All modules do the same: what the turn adds at each place is missing.",
            _targets(twist=lambda vx, vy, omega: (vx, vy, 0.0)),
        ),
        Mistake(
            "atan instead of atan2",
            "atan of a quotient cannot tell forwards from backwards, as one source prints it: a "
            "robot that should reverse drives ahead. Use atan2 with both parts.",
            _targets(angle=lambda b, a: np.arctan(b / a)),
        ),
        Mistake(
            "atan2 with its arguments swapped",
            "The angle is measured from the y axis. np.arctan2 takes y first: np.arctan2(b, a).",
            _targets(angle=lambda b, a: np.arctan2(a, b)),
        ),
        Mistake(
            "held angle forgotten",
            "A module that stands still must keep its angle: atan2 of nothing is 0, and every stop "
            "would swing all wheels ahead. Take it from hold_angles.",
            _targets(hold="never"),
        ),
        Mistake(
            "held only when all stand still",
            "A single module can stand still while the others drive: the robot turns about it. "
            "Decide for each module by its own speed.",
            _targets(hold="all"),
        ),
        Mistake(
            "compared with exactly 0",
            "The speed is compared with 0. Rounding leaves 1e-17, and its direction is chance: "
            "compare with swerve.REST.",
            _targets(hold="exact"),
        ),
        Mistake(
            "degrees, and nothing held",
            "The angles are in degrees; inside the robot all angles are in radians. And a module "
            "that stands still must keep its angle.",
            _targets(angle=lambda b, a: np.degrees(np.arctan2(b, a)), hold="never"),
        ),
        Mistake(
            "square of the speed",
            "These are squares of speeds: the root is missing.",
            _targets(speed=lambda a, b: a**2 + b**2),
        ),
        Mistake(
            "modules swapped",
            "Two modules got each other's command. The order is that of drive: front left, rear "
            "left, rear right, front right.",
            _targets(order=_swapped),
        ),
        Mistake(
            "minus for plus",
            "vy − omega · x should be vy + omega · x: in a left turn the front goes to the left.",
            _targets(along=-1.0),
        ),
        Mistake(
            "held in every turn on the spot",
            "vx and vy alone decide whether a module stands still. In a turn on the spot both are "
            "0 and all modules move: take each module's own speed.",
            _targets(hold="no way"),
        ),
        Mistake(
            "held angle, but speed 0 for all",
            "When one module stands still, all of them do. Decide for each module by itself.",
            _targets(hold="any"),
        ),
        Mistake(
            "a limit below REST",
            "The limit between still and moving is smaller than swerve.REST, 0.1 mm/s. Below that "
            "a module counts as still: speed 0, and its angle from hold_angles.",
            _targets(hold="less"),
        ),
        Mistake(
            "a crawl held",
            "A module that moves slowly is taken for one that stands still. The limit is "
            "swerve.REST, 0.1 mm/s.",
            _targets(hold="crawl"),
        ),
    ),
)

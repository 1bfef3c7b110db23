"""From the body to its modules and back, and how people get it wrong."""

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
        ("a turn about the front left module, which stands still", [-pivot[0], -pivot[1], 1.5]),
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
        a, b = vx + across * omega * y, vy + omega * x
        still = np.hypot(a, b) < swerve.REST
        if hold != "each":
            still = np.full(len(x), hold == "all" and not np.any(command))
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
            "Decide for each module by its own speed, with a limit: rounding leaves 1e-17, not 0.",
            _targets(hold="all"),
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
    ),
)


def _body_twist_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    def rolling(drive: Drive, twist: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        speeds, angles = swerve.module_targets(drive, twist, np.zeros(len(drive)))
        return np.round(speeds, 4), np.round(angles, 4)

    named = [
        ("all straight ahead", [1.0, 0.0, 0.0]),
        ("all to the left", [0.0, 0.7, 0.0]),
        ("a left turn on the spot", [0.0, 0.0, 1.5]),
        ("any motion", some_twist(rng)),
    ]
    cases = [(what, MODULES, *rolling(MODULES, np.array(twist))) for what, twist in named]
    for what, modules in (("another robot", 4), ("a robot with three modules", 3)):
        drive = some_drive(rng, modules)
        cases.append((what, drive, *rolling(drive, some_twist(rng))))
    for what in ("one wheel spins on a wet spot", "wheels and angles with noise"):
        drive = some_drive(rng)
        speeds, angles = rolling(drive, some_twist(rng))
        noise = [0.5, 0, 0, 0] if what.startswith("one") else rng.normal(0.0, 0.05, 4).round(3)
        cases.append((what, drive, speeds + noise, angles - 0.2 * np.array(noise)))
    backwards = rolling(drive, some_twist(rng))
    cases.append(("wheels that roll backwards", drive, -backwards[0], backwards[1] + np.pi))
    return [Case(what, tuple(args), "", 1e-9) for what, *args in cases]


def _twist(
    *,
    place: Callable[[np.ndarray], np.ndarray] = lambda positions: positions,
    angle: Callable[[np.ndarray], np.ndarray] = lambda angles: angles,
    across: float = -1.0,
    change: Callable[[np.ndarray], np.ndarray] = lambda twist: twist,
    used: slice = slice(None),
    mixed: bool = False,
) -> Callable[..., np.ndarray]:
    """Least squares with one of its parts wrong."""

    def function(drive: Drive, speeds: np.ndarray, angles: np.ndarray) -> np.ndarray:
        x, y = place(np.asarray(drive, float))[used].T
        speeds, turned = np.asarray(speeds)[used], angle(np.asarray(angles))[used]
        one, none = np.ones(len(x)), np.zeros(len(x))
        matrix = np.vstack([np.c_[one, none, across * y], np.c_[none, one, x]])
        seen = np.stack([speeds * np.cos(turned), speeds * np.sin(turned)])
        seen = seen.T.ravel() if mixed else seen.ravel()
        return change(np.linalg.lstsq(matrix, seen, rcond=None)[0])

    return function


def _means(drive: Drive, speeds: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Mean velocity, and mean of the turns that each module sees about the origin."""
    x, y = np.asarray(drive, float).T
    a, b = speeds * np.cos(angles), speeds * np.sin(angles)
    return np.array([a.mean(), b.mean(), np.mean((x * b - y * a) / (x**2 + y**2))])


BODY_TWIST = Exercise(
    id="swerve.body_twist",
    title="What the modules say about the body",
    points=2,
    reference=swerve.body_twist,
    shortcuts=(
        "robocon_course.swerve.motion.body_motion",
        "robocon_course.swerve.motion.fill_motion",
        "robocon_course.swerve.modules.SwerveDrive",
    ),
    cases=_body_twist_cases,
    hints=(
        "Eight equations, three unknowns: a = vx − omega · y and b = vy + omega · x, once for each "
        "module.",
        "One row (1, 0, −y) for each a and one row (0, 1, x) for each b; np.linalg.lstsq solves "
        "them.",
        "np.linalg.lstsq(np.vstack([np.c_[one, zero, -y], np.c_[zero, one, x]]), "
        "np.hstack([a, b]), rcond=None)[0] with a = speeds · cos(angles) and b = speeds · "
        "sin(angles).",
    ),
    mistakes=(
        Mistake(
            "mean of the turns",
            "vx, vy and omega are averaged each by itself. That is right only if the modules' "
            "middle is the origin and all are equally far from it. Solve for all three at once.",
            _means,
        ),
        Mistake(
            "two modules only",
            "Only the first two modules are used. The others would show that a wheel slips, and "
            "halve the noise.",
            _twist(used=slice(0, 2)),
        ),
        Mistake(
            "degrees",
            "The angles are taken for degrees, or turned once more. They are in radians already.",
            _twist(angle=np.radians),
        ),
        Mistake(
            "sign of omega",
            "omega has the wrong sign: a left turn is positive.",
            _twist(change=lambda twist: twist * [1.0, 1.0, -1.0]),
        ),
        Mistake(
            "plus for minus",
            "The rows of a should be (1, 0, −y): in a left turn the left side runs backwards.",
            _twist(across=1.0),
        ),
        Mistake(
            "x and y swapped",
            "The module's x and y are exchanged: rows (1, 0, −y) and (0, 1, x).",
            _twist(place=lambda positions: positions[:, ::-1]),
        ),
        Mistake(
            "sine and cosine swapped",
            "The components are exchanged: forward is speed · cos(angle), left is speed · "
            "sin(angle).",
            _twist(angle=lambda angles: np.pi / 2 - angles),
        ),
        Mistake(
            "rows in another order",
            "The rows of the matrix and the components do not belong together: one goes a, a, …, "
            "b, b, …, the other a, b, a, b, ….",
            _twist(mixed=True),
        ),
    ),
)

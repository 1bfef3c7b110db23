"""From the modules back to the body, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import swerve
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.swerve.kinematics import Drive, some_drive, some_twist
from robocon_course.robot import MODULES
from robocon_course.worlds import Student


def _body_twist_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    def rolling(drive: Drive, twist: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        speeds, angles = swerve.module_targets(drive, twist, np.zeros(len(drive)))
        return speeds, angles  # not rounded: the modules of a clean case agree to the last digit

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
    whole: bool = False,
) -> Callable[..., np.ndarray]:
    """Least squares with one of its parts wrong."""

    def function(drive: Drive, speeds: np.ndarray, angles: np.ndarray) -> np.ndarray:
        x, y = place(np.asarray(drive, float))[used].T
        speeds, turned = np.asarray(speeds)[used], angle(np.asarray(angles))[used]
        one, none = np.ones(len(x)), np.zeros(len(x))
        matrix = np.vstack([np.c_[one, none, across * y], np.c_[none, one, x]])
        seen = np.stack([speeds * np.cos(turned), speeds * np.sin(turned)])
        seen = seen.T.ravel() if mixed else seen.ravel()
        found = np.linalg.lstsq(matrix, seen, rcond=None)
        return found if whole else change(found[0])

    return function


def _means(drive: Drive, speeds: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Mean velocity, and mean of the turns that each module sees about the origin."""
    x, y = np.asarray(drive, float).T
    a, b = speeds * np.cos(angles), speeds * np.sin(angles)
    return np.array([a.mean(), b.mean(), np.mean((x * b - y * a) / (x**2 + y**2))])


def _forward_only(drive: Drive, speeds: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Least squares on the rows of a alone."""
    y = np.asarray(drive, float)[:, 1]
    matrix = np.column_stack([np.ones_like(y), np.zeros_like(y), -y])
    return np.linalg.lstsq(matrix, speeds * np.cos(angles), rcond=None)[0]


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
        Mistake(
            "all that lstsq gives",
            "np.linalg.lstsq gives four things, and the solution is the first: [0] at its end.",
            _twist(whole=True),
        ),
        Mistake(
            "only forward rows",
            "Half of the equations are missing: each module gives a row for a and a row for b.",
            _forward_only,
        ),
    ),
)

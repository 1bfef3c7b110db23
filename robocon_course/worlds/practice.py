"""The practice world of chapter 05: one student's cart, and carts and paths to be tuned for."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from robocon_course._arrays import FloatArray
from robocon_course.geometry import distance_along
from robocon_course.tracking import Cart, DifferentialModel
from robocon_course.worlds.student import Student, generator

SOURCE_PATHS = {
    "square": ((0.0, 0.0), (0.0, 1.5), (1.5, 1.5), (1.51, 0.0)),
    "roof": ((0.0, 0.0), (0.0, 1.0), (0.5, 1.5), (0.99, 0.5)),
    "zigzag": ((0.0, 0.0), (0.0, 1.5), (-1.0, 1.47), (-0.5, 0.46), (-1.49, -0.01)),
}
"""Test paths of the source from Surabaya [m, map]."""
PUBLISHED = {0.25: ((-0.10, 0.10), (-0.07, 0.14)), 0.38: ((-0.10, 0.10), (-0.07, 0.10))}
"""By speed [m/s]: least and greatest deviation it reports, in x and in y [m]."""

SMALL = 0.002  # rad: so that no wheel reaches its limit
SPACING = 0.02  # m


@dataclass(frozen=True)
class PracticeWorld:
    """One student's cart.

    Attributes
    ----------
    model : DifferentialModel
    """

    model: DifferentialModel

    def swing(self, gain: float, seconds: float = 2.5) -> FloatArray:
        """The experiment of Ziegler and Nichols: the cart drives ahead, 0.002 rad off its heading.

        Parameters
        ----------
        gain : float  [m/s per rad]
            By so much the right wheel is told to be faster than the left, times the heading error.
        seconds : float  [s]

        Returns
        -------
        ndarray, shape (n,)  [rad]
            Heading error every 10 ms.
        """
        cart, errors = Cart(self.model, (0.0, 0.0, SMALL)), []
        for _ in range(round(100 * seconds)):
            errors.append(-float(cart.state.pose[2]))
            cart.drive(0.25, gain * errors[-1] / self.model.wheel_base)
        return np.array(errors)


@functools.lru_cache(maxsize=8)
def practice_world(student: Student) -> PracticeWorld:
    """One student's cart: the same to the bit on every machine."""
    rng = generator(student, "practice")
    lag, base = round(rng.uniform(0.05, 0.12), 3), round(rng.uniform(0.22, 0.38), 3)
    return PracticeWorld(DifferentialModel(wheel_base=base, lag=lag))


def some_cart(rng: np.random.Generator) -> DifferentialModel:
    """A cart that nobody has seen: its lag decides how it has to be driven."""
    lag = np.exp(rng.uniform(np.log(0.04), np.log(0.10)))
    return DifferentialModel(
        wheel_base=float(round(rng.uniform(0.2, 0.4), 3)),
        lag=float(round(lag, 3)),
        max_speed=float(round(rng.uniform(0.5, 0.8), 2)),
    )


def winding_path(rng: np.random.Generator, length: float = 5.0) -> FloatArray:
    """A path with bends and two corners, a point every 2 cm, shape (n, 2) [m, map]."""
    s = np.arange(0.0, length, SPACING)
    bend = np.zeros_like(s)
    for _ in range(3):
        wave = s / rng.uniform(1.2, 3.5) + rng.uniform()
        bend += rng.uniform(0.3, 1.2) * np.sin(2.0 * np.pi * wave)
    heading = np.cumsum(SPACING * bend * np.clip(s / 0.4, 0.0, 1.0))
    for corner in (1, 2):
        at = int(len(s) * (corner + rng.uniform(-0.25, 0.25)) / 3)
        heading[at:] += np.radians(rng.uniform(70.0, 90.0)) * rng.choice([-1.0, 1.0])
    steps = SPACING * np.column_stack([np.cos(heading), np.sin(heading)])
    return np.round(np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]), 3)


def finely(path: FloatArray, spacing: float = 0.01) -> FloatArray:
    """The same path with a point at least every so many metres, its own among them."""
    path = np.asarray(path, float)
    s = distance_along(path)
    places = np.union1d(np.linspace(0.0, s[-1], round(s[-1] / spacing) + 1), s)
    return np.column_stack([np.interp(places, s, path[:, 0]), np.interp(places, s, path[:, 1])])

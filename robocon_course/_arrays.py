"""The guard at the door: shape, finiteness and meaning are checked here, once."""

from __future__ import annotations

from dataclasses import fields
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


class CourseError(Exception):
    """Base of the course's own errors; each message is a sentence a student can act on."""


def as_floats(value: ArrayLike, name: str, *shape: int | None, finite: bool = True) -> FloatArray:
    """``value`` as a C-contiguous float64 array of the given shape.

    Parameters
    ----------
    value : array_like
    name : str
        Name of the argument, for the message.
    *shape : int or None
        Wanted length of each axis; None means any length.
    finite : bool
        Refuse NaN and infinity. Sensor logs pass False: a control loop skips bad samples instead.

    Returns
    -------
    ndarray

    Raises
    ------
    ValueError
        Not numbers, another shape, or (with ``finite``) an entry that is not finite.
    """
    try:
        array = np.asarray(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected numbers, got {type(value).__name__}") from None
    # The sentence is built only where it is needed: control loops pass here at every sample.
    if array.shape != shape and not _fits(array.shape, shape):
        wanted = ", ".join("n" if n is None else str(n) for n in shape)
        comma = "," if len(shape) == 1 else ""
        raise ValueError(f"{name}: expected shape ({wanted}{comma}), got {array.shape}")
    if finite and not _finite(array):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(
            f"{name}: entry {where} is not a finite number; remove it or mend it first"
        )
    return array


def _finite(array: FloatArray) -> bool:
    """Whether every entry is; numpy takes longer to begin than a few numbers take in Python."""
    if array.size <= 12:
        return all(map(isfinite, array.ravel().tolist()))
    return bool(np.isfinite(array).all())


def _fits(got: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    if len(got) != len(wanted):
        return False
    for length, other in zip(got, wanted, strict=True):
        if other is not None and other != length:
            return False
    return True


def as_vectors(value: ArrayLike, name: str, size: int) -> FloatArray:
    """``value`` as a float array of shape (..., size); NaN may pass, another last axis may not.

    Parameters
    ----------
    value : array_like, shape (..., size)
    name : str
        Name of the argument, for the message.
    size : int
        Wanted length of the last axis.

    Returns
    -------
    ndarray, shape (..., size)

    Raises
    ------
    ValueError
        Not numbers, or another last axis.
    """
    leading = (None,) * (np.ndim(value) - 1)
    return as_floats(value, name, *leading, size, finite=False)


def as_distance(value: float, name: str) -> float:
    """A distance from 0 on, checked.

    Parameters
    ----------
    value : float  [m]
    name : str
        Name of the argument, for the message.

    Returns
    -------
    float  [m]

    Raises
    ------
    ValueError
        Not one finite number, or negative.
    """
    distance = float(as_floats(value, name))
    if distance < 0.0:
        raise ValueError(f"{name}: must not be negative, got {value!r}")
    return distance


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """A copy of an array that nobody can write to."""
    array = array.copy()
    array.flags.writeable = False
    return array


def freeze_arrays(record: Any) -> None:
    """Put read-only copies in the place of all arrays of a frozen dataclass.

    As its ``__post_init__``: "frozen" alone keeps the names, not what the arrays hold.

    Parameters
    ----------
    record : instance of a dataclass
    """
    for field in fields(record):
        value = getattr(record, field.name)
        if isinstance(value, np.ndarray):
            object.__setattr__(record, field.name, frozen(value))

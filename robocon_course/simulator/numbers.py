"""Numbers of a model, checked one by one under their names."""

from __future__ import annotations

from math import inf
from numbers import Real


def require_positive(record: object, *names: str) -> None:
    """Refuse a record in which one of these is not a finite number above 0.

    Parameters
    ----------
    record : object
    *names : str
        Of its attributes.

    Raises
    ------
    ValueError
        The first that is none, with its name.
    """
    for name in names:
        value = getattr(record, name)
        if not (isinstance(value, Real) and 0.0 < value < inf):
            raise ValueError(f"{name}: must be positive, got {value!r}")


def require_not_negative(record: object, *names: str) -> None:
    """Refuse a record in which one of these is not a finite number, 0 or more.

    Parameters
    ----------
    record : object
    *names : str
        Of its attributes.

    Raises
    ------
    ValueError
        The first that is none, with its name.
    """
    for name in names:
        value = getattr(record, name)
        if not (isinstance(value, Real) and 0.0 <= value < inf):
            raise ValueError(f"{name}: must not be negative, got {value!r}")

"""Numbers of a model, checked one by one under their names."""

from __future__ import annotations

from math import inf
from numbers import Real


def require(record: object, *names: str, zero: bool = False) -> None:
    """Refuse a record in which one of these is not a finite number above 0.

    Parameters
    ----------
    record : object
    *names : str
        Of its attributes.
    zero : bool
        Whether 0 may pass, too.

    Raises
    ------
    ValueError
        The first that is none, with its name.
    """
    rule = "must not be negative" if zero else "must be positive"
    for name in names:
        value = getattr(record, name)
        if not (isinstance(value, Real) and 0.0 <= value < inf and (zero or value > 0.0)):
            raise ValueError(f"{name}: {rule}, got {value!r}")

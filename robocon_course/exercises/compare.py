"""Is what came the same as what was expected? If not: where, by how much, in words."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from robocon_course.answers.wire import Foreign, fields_of

Tolerance = float | dict[str, float]

NOTHING = "the function returned nothing (None); is a return missing?"


def difference(got: Any, expected: Any, atol: Tolerance, unit: str = "") -> str | None:
    """The first difference between two results as a sentence, None where they agree.

    Parameters
    ----------
    got, expected : numbers, arrays, or nested tuples, lists and dictionaries of them
        Field by field and entry by entry; lists count as arrays where an array is expected.
    atol : float or dict of float
        Largest difference that still counts as equal, in ``unit``; by field for a result object.
    unit : str
        One for all, or one for each entry of the last axis: "m, m, rad".
    """
    if got is None:
        return NOTHING
    fields = fields_of(expected)
    if fields is not None:
        return _fields(got, expected, fields, atol, unit)
    if isinstance(got, Foreign):
        return f"expected {kind_of(expected)}, got an object of type {got.type_name}"
    if isinstance(expected, set):
        return _set(got, expected)
    if isinstance(expected, tuple | list) and not _numeric(expected):
        return _sequence(got, expected, atol, unit)
    return _numbers(got, expected, atol, unit)


def shown(value: Any) -> str:
    """A value as a student would write it: short, rounded."""
    if isinstance(value, Foreign):
        return f"{value.type_name} object"
    fields = fields_of(value)
    if fields is not None:
        return ", ".join(f"{key} = {shown(item)}" for key, item in fields.items())
    if isinstance(value, np.ndarray) and value.size > 12:
        return f"array of shape {value.shape}, first row {shown(value[0])}"
    if isinstance(value, np.ndarray | float | int) and not isinstance(value, bool):
        return np.array2string(np.asarray(value), precision=4, suppress_small=True, separator=", ")
    if isinstance(value, set | frozenset):
        return "{" + ", ".join(sorted(map(shown, value))) + "}"
    if isinstance(value, tuple | list):
        return "(" + ", ".join(shown(item) for item in value) + ")"
    return repr(value)[:80]


def _fields(
    got: Any, expected: Any, fields: dict[str, Any], atol: Tolerance, unit: str
) -> str | None:
    """Compare result objects; a part must return the type that the rest of the robot reads."""
    name = type(expected).__name__
    if type(got).__name__ != name:
        form = ", ".join(f"{field}=…" for field in fields)
        room = type(expected).__module__.split(".")[1]
        return f"expected {room}.{name}({form}), got {kind_of(got)}"
    for field, wanted in fields.items():
        # A field without a tolerance is not judged, but it must have the right form.
        limit = atol.get(field, sys.float_info.max) if isinstance(atol, dict) else atol
        came = getattr(got, field)
        found = _cells(came, wanted, field)
        if found:
            return found
        found = difference(came, wanted, limit, unit)
        if found:
            return f"{field}: {found}"
    return None


def _cells(got: Any, expected: Any, what: str) -> str | None:
    """The first cell of a map of yes and no that is wrong, in the field's own word: free."""
    maps = all(
        isinstance(m, np.ndarray) and m.ndim == 2 and m.dtype == bool for m in (got, expected)
    )
    if not maps or got.shape != expected.shape or (got == expected).all():
        return None
    row, col = np.argwhere(got != expected)[0].tolist()
    if got[row, col]:
        return f"cell ({row}, {col}) should not be {what}, and is"
    return f"cell ({row}, {col}) should be {what}, and is not"


def _sequence(got: Any, expected: tuple | list, atol: float, unit: str) -> str | None:
    got = got.item() if isinstance(got, np.ndarray) and got.ndim == 0 else got
    if not isinstance(got, tuple | list | np.ndarray) or len(got) != len(expected):
        return f"expected {len(expected)} results, got {kind_of(got)}"
    for number, (one, wanted) in enumerate(zip(got, expected, strict=True)):
        found = difference(one, wanted, atol, unit)
        if found:
            return f"result {number + 1} of {len(expected)}: {found}"
    return None


def _set(got: Any, expected: set) -> str | None:
    """What is missing from a set, or too much."""
    if not isinstance(got, set | frozenset):
        return f"expected a set, got {kind_of(got)}"
    if expected - got:
        return f"{_members(expected - got)} missing"
    return f"{_members(got - expected)} too much" if got - expected else None


def _members(some: set) -> str:
    return ", ".join(sorted(map(repr, some))) + (" is" if len(some) == 1 else " are")


def _numbers(got: Any, expected: Any, atol: float, unit: str) -> str | None:
    if isinstance(expected, bool | str):
        same = isinstance(got, bool | str | np.ndarray) and np.all(got == expected)
        return None if same else f"expected {expected!r}, got {shown(got)}"
    wanted = np.asarray(expected, dtype=float)
    try:
        came = np.asarray(got)
    except ValueError:  # lists of unequal length
        return f"expected {kind_of(expected)}, got {kind_of(got)}"
    if came.dtype.kind not in "biuf":
        large = isinstance(got, int) or (came.dtype.kind == "O" and _numeric(came.ravel().tolist()))
        what = "one too large for a float" if large else kind_of(got)
        return f"expected {kind_of(expected)}, got {what}"
    came = came.astype(float)
    if came.shape != wanted.shape:
        return f"expected {kind_of(wanted)}, got {kind_of(came)}"
    off = ~np.isclose(came, wanted, rtol=0.0, atol=atol, equal_nan=True)
    if not off.any():
        return None
    where = tuple(int(i) for i in np.argwhere(off)[0])
    place = f" at entry {list(where)}" if where else ""
    units = unit.split(", ")
    if where and len(units) == wanted.shape[-1]:  # "m, m, rad": one for each column
        unit = units[where[-1]]
    unit = f" {unit}" if unit else ""
    want, came_text = _apart(float(wanted[where]), float(came[where]))
    return f"expected {want}{unit}, got {came_text}{unit}{place}"


def _apart(one: float, other: float) -> tuple[str, str]:
    """Two numbers with as many digits as it takes to tell them apart; rounding's dust is 0."""
    if one.is_integer() and other.is_integer() and max(abs(one), abs(other)) < 1e9:
        return f"{one:.0f}", f"{other:.0f}"  # counts
    if abs(one - other) > 1e-9:
        one, other = (0.0 if abs(number) < 1e-12 else number for number in (one, other))
    texts = ((f"{one:.{d}g}", f"{other:.{d}g}") for d in range(4, 18))
    return next((pair for pair in texts if pair[0] != pair[1]), (repr(one), repr(other)))


def _numeric(value: Any) -> bool:
    return all(isinstance(item, int | float) and not isinstance(item, bool) for item in value)


def kind_of(value: Any) -> str:
    """What a value is, in words: "an array of shape (3, 2)"."""
    if isinstance(value, Foreign):
        return f"an object of type {value.type_name}"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}" if value.ndim else "a number"
    if isinstance(value, bool | str | dict | set | frozenset):
        return f"a {type(value).__name__}"
    if isinstance(value, int | float):
        return "a number"
    if isinstance(value, tuple | list):
        return f"a {type(value).__name__} of {len(value)}"
    return f"an object of type {type(value).__name__}"

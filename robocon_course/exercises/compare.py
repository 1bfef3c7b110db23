"""Is what came the same as what was expected? If not: where, by how much, in words."""

from __future__ import annotations

from typing import Any

import numpy as np

from robocon_course.answers.wire import Foreign


def difference(got: Any, expected: Any, atol: float, unit: str = "") -> str | None:
    """The first difference between two results as a sentence, None where they agree.

    Parameters
    ----------
    got, expected : numbers, arrays, or nested tuples, lists and dictionaries of them
        Field by field and entry by entry; lists count as arrays where an array is expected.
    atol : float
        Largest difference that still counts as equal, in ``unit``.
    unit : str
    """
    if got is None:
        return "the function returned nothing (None); is a return missing?"
    if isinstance(got, Foreign):
        return f"expected {_kind(expected)}, got an object of type {got.type_name}"
    if isinstance(expected, dict):
        return _parts(_by_name(got, expected), expected, atol, unit)
    if isinstance(expected, tuple | list) and not _numeric(expected):
        return _sequence(got, expected, atol, unit)
    return _numbers(got, expected, atol, unit)


def fields_of(value: Any, names: tuple[str, ...]) -> Any:
    """The named attributes of a result as a dictionary; the result itself without names."""
    if not names or value is None or isinstance(value, Foreign):
        return value
    return {name: getattr(value, name, None) for name in names}


def shown(value: Any) -> str:
    """A value as a student would write it: short, rounded."""
    if isinstance(value, Foreign):
        return f"{value.type_name} object"
    if isinstance(value, dict):
        return ", ".join(f"{key} = {shown(item)}" for key, item in value.items())
    if isinstance(value, np.ndarray) and value.size > 12:
        return f"array of shape {value.shape}, first row {shown(value[0])}"
    if isinstance(value, np.ndarray | float | int) and not isinstance(value, bool):
        return np.array2string(np.asarray(value), precision=4, suppress_small=True, separator=", ")
    if isinstance(value, tuple | list):
        return "(" + ", ".join(shown(item) for item in value) + ")"
    return repr(value)[:80]


def _by_name(got: Any, expected: dict[str, Any]) -> dict[str, Any]:
    if isinstance(got, dict):
        return got
    return {name: getattr(got, name, None) for name in expected}


def _parts(got: dict[str, Any], expected: dict[str, Any], atol: float, unit: str) -> str | None:
    for name, wanted in expected.items():
        if got.get(name) is None:
            return f"the result has no {name}"
        found = difference(got[name], wanted, atol, unit)
        if found:
            return f"{name}: {found}"
    return None


def _sequence(got: Any, expected: tuple | list, atol: float, unit: str) -> str | None:
    got = got.item() if isinstance(got, np.ndarray) and got.ndim == 0 else got
    if not isinstance(got, tuple | list | np.ndarray) or len(got) != len(expected):
        return f"expected {len(expected)} results, got {_kind(got)}"
    names = getattr(expected, "_fields", range(len(expected)))
    for name, one, wanted in zip(names, got, expected, strict=True):
        found = difference(one, wanted, atol, unit)
        if found:
            return f"{name}: {found}"
    return None


def _numbers(got: Any, expected: Any, atol: float, unit: str) -> str | None:
    if isinstance(expected, bool | str):
        same = isinstance(got, bool | str | np.ndarray) and np.all(got == expected)
        return None if same else f"expected {expected!r}, got {shown(got)}"
    wanted = np.asarray(expected, dtype=float)
    try:
        came = np.asarray(got, dtype=float)
    except (TypeError, ValueError):
        return f"expected {_kind(expected)}, got {_kind(got)}"
    except OverflowError:
        return f"expected {_kind(expected)}, got one too large for a float"
    if came.shape != wanted.shape:
        return f"expected {_kind(wanted)}, got {_kind(came)}"
    off = ~np.isclose(came, wanted, rtol=0.0, atol=atol, equal_nan=True)
    if not off.any():
        return None
    where = tuple(int(i) for i in np.argwhere(off)[0])
    place = f" at entry {list(where)}" if where else ""
    unit = f" {unit}" if unit else ""
    return f"expected {wanted[where]:.4g}{unit}, got {came[where]:.4g}{unit}{place}"


def _numeric(value: Any) -> bool:
    return all(isinstance(item, int | float) and not isinstance(item, bool) for item in value)


def _kind(value: Any) -> str:
    if isinstance(value, Foreign):
        return f"an object of type {value.type_name}"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}" if value.ndim else "a number"
    if isinstance(value, bool | str | dict):
        return f"a {type(value).__name__}"
    if isinstance(value, int | float):
        return "a number"
    if isinstance(value, tuple | list):
        return f"{len(value)} values"
    return f"an object of type {type(value).__name__}"

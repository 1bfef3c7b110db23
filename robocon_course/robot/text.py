"""Objects as JSON text and back, to the bit; and the fields of objects that came from elsewhere.

Floats are written as the shortest decimal that reads back as the same float. JSON has no NaN: such
a field is left out, and a number that is missing reads as NaN. Infinity is ``1e999``, which JSON
allows and every reader of floats takes for infinity. (Two NaNs with different bits become one.)
"""

from __future__ import annotations

import json
from math import inf, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

Tree = dict[str, Any]


def to_text(tree: Tree) -> bytes:
    """JSON of an object.

    Parameters
    ----------
    tree : dict
        Texts, numbers, truth values, lists and dicts of them.

    Returns
    -------
    bytes
        UTF-8, one line. A NaN leaves its field out, infinity is ``1e999``.

    Raises
    ------
    ValueError
        NaN in a list, where leaving it out would move the others.

    Examples
    --------
    >>> to_text({"a": 0.1, "b": float("nan"), "c": float("inf")})
    b'{"a":0.1,"c":1e999}'
    """
    try:
        return _dumps(tree).encode()
    except ValueError:  # a number that JSON does not have; rare, so the slow way
        return _spell(tree).encode()


_dumps = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode


def _spell(value: Any) -> str:
    """JSON of anything, number by number."""
    if isinstance(value, dict):
        kept = (item for item in value.items() if not (item[1] != item[1]))
        return "{" + ",".join(f"{json.dumps(key)}:{_spell(inner)}" for key, inner in kept) + "}"
    if isinstance(value, list | tuple):
        return "[" + ",".join(map(_spell, value)) + "]"
    if value in (inf, -inf):
        return "1e999" if value > 0 else "-1e999"
    return _dumps(value)


def from_text(data: bytes) -> Tree:
    """The object that a JSON text holds.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    dict

    Raises
    ------
    ValueError
        No JSON, or no object.
    """
    try:
        tree = json.loads(data, parse_constant=_no_constant)
    except RecursionError:
        raise ValueError("expected JSON, got brackets without end") from None
    if not isinstance(tree, dict):
        raise ValueError(f"expected a JSON object, got {type(tree).__name__}")
    return tree


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no JSON")


# --- fields ---------------------------------------------------------------------------------------


def number(tree: Tree, name: str) -> float:
    """A number of an object.

    Parameters
    ----------
    tree : dict
    name : str
        Of the field.

    Returns
    -------
    float
        NaN where it is missing.

    Raises
    ------
    ValueError
        The field is no number.
    """
    value = tree.get(name, nan)
    if type(value) is float:
        return value
    if type(value) is int:
        try:
            return float(value)
        except OverflowError:
            pass
    raise ValueError(f"{name}: expected a number, got {value!r:.40}")


def field(tree: Tree, name: str, kind: type) -> Any:
    """A field that must be there.

    Parameters
    ----------
    tree : dict
    name : str
        Of the field.
    kind : type
        ``int``, ``bool``, ``str``, ``list`` or ``dict``; a bool is no int.

    Raises
    ------
    ValueError
        It is missing, or of another type.
    """
    value = tree.get(name)
    if type(value) is not kind:
        raise ValueError(f"{name}: expected {kind.__name__}, got {value!r:.40}")
    return value


def things(tree: Tree, name: str, count: int | None = None) -> list[Tree]:
    """A list of objects that must be there.

    Parameters
    ----------
    tree : dict
    name : str
        Of the field.
    count : int, optional
        How many there must be.

    Raises
    ------
    ValueError
        It is missing, no list of objects, or holds another number of them.
    """
    items = field(tree, name, list)
    if count is not None and len(items) != count:
        raise ValueError(f"{name}: expected {count}, got {len(items)}")
    for item in items:
        if type(item) is not dict:
            raise ValueError(f"{name}: expected objects, got {item!r:.40}")
    return items


def rows(items: list[Tree], *names: str) -> NDArray[np.float64]:
    """Numbers of a list of objects.

    Parameters
    ----------
    items : list of dict
    *names : str
        Of the fields.

    Returns
    -------
    ndarray, shape (objects, names)
        NaN where one is missing.

    Raises
    ------
    ValueError
        A field is no number.
    """
    values = [[number(item, name) for name in names] for item in items]
    return np.array(values, float).reshape(len(items), len(names))


def wholes(values: list, name: str) -> NDArray[np.int64]:
    """Whole numbers that came from elsewhere.

    Parameters
    ----------
    values : list
    name : str
        For the message.

    Returns
    -------
    ndarray of int64, shape (n,)

    Raises
    ------
    ValueError
        One is no whole number, or needs more than 64 bits.
    """
    if not all(type(value) is int and -(2**63) <= value < 2**63 for value in values):
        raise ValueError(f"{name}: expected whole numbers, got {values!r:.60}")
    return np.array(values, np.int64)

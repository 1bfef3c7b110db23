"""Plain data between the judge and the process that runs a student's code.

Numbers, text, arrays, lists, tuples, sets, dictionaries and the course's own result types pass.
Anything else arrives as a ``Foreign`` that only says what it was: no object of a student ever
comes to life beside the checks, so none can pretend to be equal to everything.
"""

from __future__ import annotations

import base64
import dataclasses
import io
import json
import math
import sys
from typing import Any, NamedTuple

import numpy as np

READY = b'"ready"\n'  # the first line a worker writes


class Foreign(NamedTuple):
    """Stands for a value that is not plain data."""

    type_name: str
    text: str


def dumps(value: Any) -> bytes:
    """``value`` as one line of JSON."""
    return json.dumps(_pack(value)).encode() + b"\n"


def loads(line: bytes) -> Any:
    """The value in one line written by ``dumps``.

    Raises
    ------
    ValueError
        The line is not such a value.
    """
    try:
        return _unpack(json.loads(line))
    except Exception as error:  # the line may come from hostile hands
        raise ValueError(f"not plain data: {error}") from None


def _pack(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return _pack(value.item())
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        file = io.BytesIO()
        np.save(file, np.asarray(value), allow_pickle=False)
        return {"array": base64.b64encode(file.getvalue()).decode()}
    fields = fields_of(value)
    if fields is not None:
        kind = type(value)
        return {"type": [kind.__module__, kind.__qualname__], "fields": _pack_all(fields)}
    if isinstance(value, list | tuple):
        key = "list" if isinstance(value, list) else "tuple"
        return {key: [_pack(item) for item in value]}
    if isinstance(value, set | frozenset):
        return {"set": sorted((_pack(item) for item in value), key=repr)}
    if isinstance(value, dict) and all(isinstance(key, str) for key in value):
        return {"dict": _pack_all(value)}
    return {"foreign": [type(value).__name__, _short(value)]}


def _pack_all(mapping: dict[str, Any]) -> dict[str, Any]:
    return {key: _pack(item) for key, item in mapping.items()}


def fields_of(value: Any) -> dict[str, Any] | None:
    """Fields of one of the course's named tuples and data classes, None for anything else."""
    if not type(value).__module__.startswith("robocon_course."):
        return None
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return {name: getattr(value, name) for name in value._fields}
    if dataclasses.is_dataclass(value):
        return {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    return None


def _short(value: Any) -> str:
    try:
        return repr(value)[:200]
    except Exception as error:  # a student's __repr__ may do anything
        return f"(its repr raises {type(error).__name__})"


def _unpack(data: Any) -> Any:
    if not isinstance(data, dict):
        return data
    if "array" in data:
        return _array(base64.b64decode(data["array"]))
    if "list" in data:
        return [_unpack(item) for item in data["list"]]
    if "tuple" in data:
        return tuple(_unpack(item) for item in data["tuple"])
    if "set" in data:
        return {_unpack(item) for item in data["set"]}
    if "dict" in data:
        return {key: _unpack(item) for key, item in data["dict"].items()}
    if "type" in data:
        fields = {key: _unpack(item) for key, item in data["fields"].items()}
        return _course_type(*data["type"])(**fields)
    return Foreign(*data["foreign"])


def _array(packed: bytes) -> np.ndarray:
    """An array of plain numbers that is as large as its header says, checked before it is made."""
    file = io.BytesIO(packed)
    np.lib.format.read_magic(file)
    shape, _, dtype = np.lib.format.read_array_header_1_0(file)
    if dtype.kind not in "biuf" or math.prod(shape) * dtype.itemsize != len(packed) - file.tell():
        raise ValueError(f"no array of plain numbers: {dtype}, shape {shape}")
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)


def _course_type(module: str, name: str) -> type:
    """A result type of the course, loaded already; nothing is imported on a message's word."""
    found = getattr(sys.modules.get(module), name, None)
    plain = dataclasses.is_dataclass(found) or hasattr(found, "_fields")
    own = module.startswith("robocon_course.") and getattr(found, "__module__", "") == module
    if not (isinstance(found, type) and plain and own):
        raise ValueError(f"{module}.{name} is not a type of the course")
    return found

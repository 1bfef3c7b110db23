"""From a student's function to a text that runs on its own.

The text holds the function, the helpers, imports and CONSTANTS it uses, and nothing else of the
notebook: a function that leans on a stray variable would not work in the robot, so the variable
is named instead. The same rules serve a live notebook and a notebook file.
"""

from __future__ import annotations

import ast
import builtins
import dis
import importlib
import inspect
import linecache
import math
import re
import sys
import textwrap
import types
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

Lookup = Callable[[str], str | None]

# What a star brings, for the modules that beginners import so; others would have to be run to know.
STARS = {"math": dir(math), "numpy": np.__all__}
UNREADABLE = (ValueError, RecursionError, MemoryError)  # a null byte, ten thousand brackets


@dataclass(frozen=True)
class Answer:
    """A function with all it needs, as text, and the names that were not found."""

    name: str
    text: str
    missing: tuple[str, ...] = ()


def assemble(name: str, lookup: Lookup) -> Answer | None:
    """The function ``name`` with everything it uses, imports first; None if it is not there.

    Parameters
    ----------
    name : str
    lookup : callable
        ``lookup(name) -> text or None``: the statement that defines a name.
    """
    seen: set[str] = set()
    missing: list[str] = []
    statements: list[str] = []

    def add(wanted: str) -> None:
        """Put a name's statement behind those of all that it uses."""
        if wanted in seen:
            return
        seen.add(wanted)
        text = lookup(wanted)
        if text is None:
            missing.extend([] if hasattr(builtins, wanted) else [wanted])
            return
        for used in free_names(text):
            add(used)
        statements.append(text)

    add(name)
    if name in missing:
        return None
    ordered = sorted(dict.fromkeys(statements), key=lambda text: not _is_import(text))
    text = "\n\n".join(["from __future__ import annotations", *ordered]) + "\n"
    return Answer(name, text, tuple(missing))


def advice_on_missing(answer: Answer, topic: str) -> str:
    """What to do about names that an answer uses and the robot does not have."""
    text = f"{answer.name} uses {', '.join(answer.missing)}, which it is not given. "
    modules = [name for name in answer.missing if name in sys.stdlib_module_names]
    if modules:
        lines = " and ".join(f"import {name}" for name in modules)
        return text + f"Write {lines} above the function, run the cell, and check again."
    for place in (f"robocon_course.{topic}", "robocon_course.geometry"):
        room = importlib.import_module(place) if find_spec(place) else None
        for name in answer.missing:
            if hasattr(room, name):
                return text + f"Write {place.partition('.')[2]}.{name}."
    return text + (
        "In the robot there is no notebook: work it out inside the function, or write a constant "
        "in CAPITALS. If it is a module such as np, run the notebook's first cell again."
    )


def free_names(text: str) -> list[str]:
    """Names that a statement takes from outside itself, in order."""
    whole = compile("from __future__ import annotations\n" + text, "<text>", "exec")
    found: dict[str, None] = {}
    for code in _codes(whole):
        steps = list(dis.get_instructions(code))
        own = {step.argval for step in steps if step.opname == "STORE_NAME"}
        reads = [s.argval for s in steps if s.opname in ("LOAD_GLOBAL", "LOAD_NAME")]
        found |= dict.fromkeys(name for name in reads if name not in own)
    given = {getattr(node, "name", "") for node in ast.parse(text).body}
    # Names like __annotations__ are Python's own, and which there are differs between versions.
    return [name for name in found if name not in given and not name.startswith("__")]


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """A code object and all those inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def from_namespace(namespace: dict[str, Any]) -> Lookup:
    """Look names up in a live notebook."""

    def lookup(name: str) -> str | None:
        if name not in namespace:
            return None
        # An imported number, an array, a class without methods, a timed cell: their cells have
        # the text.
        return _statement(name, namespace[name]) or from_cells(namespace.get("In", []))(name)

    return lookup


def from_cells(cells: Iterable[str]) -> Lookup:
    """Look names up in the text of a notebook's code cells; the last definition counts."""
    found: dict[str, str] = {}
    for cell in cells:
        for node, text in _statements(cell):
            if isinstance(node, ast.Import | ast.ImportFrom):
                names = [alias.asname or alias.name.partition(".")[0] for alias in node.names]
                if names == ["*"]:
                    names = STARS.get(getattr(node, "module", ""), [])
                found |= dict.fromkeys(names, text)
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                found[node.name] = text
            elif _names_a_function(node, found):
                found[node.targets[0].id] = text
            else:
                found |= dict.fromkeys(_constants(node), text)
    return found.get


def definition_in(cell: str, name: str) -> str | None:
    """The text of function or class ``name`` in a cell; the last one, as Python has it."""
    found = None
    for node, text in _statements(cell):
        if getattr(node, "name", None) == name:
            found = text
    return found


def broken_definition(name: str, cells: Iterable[str]) -> str:
    """Say where the newest cell with ``def name`` breaks Python's grammar; empty if it does not."""
    newest = [cell for cell in cells if re.search(rf"\bdef {name}\b", cell)][-1:]
    for cell in newest:
        try:
            _grammar(cell)
        except SyntaxError as error:
            line, kind = (error.text or "").strip(), type(error).__name__
            return f"The cell with def {name} has a {kind} in line {error.lineno}: {line}"
        except UNREADABLE as error:
            return f"The cell with def {name} cannot be read ({type(error).__name__})."
    return ""


def not_run(answer: Answer, cells: Iterable[str]) -> bool:
    """Whether the newest cell with the answer's ``def`` is not the one that the answer is from."""
    newest = [cell for cell in cells if re.search(rf"\bdef {answer.name}\b", cell)][-1:]
    texts = [definition_in(cell, answer.name) for cell in newest]
    return any(text is not None and text not in answer.text for text in texts)


def plain_code(cell: str) -> str:
    """A cell without IPython's magics and shell lines, line numbers kept."""
    try:
        ast.parse(cell)
        return cell  # plain Python already; a line may well begin with the operator %
    except (SyntaxError, *UNREADABLE):
        lines = cell.splitlines()
    if cell.startswith("%%") and not re.match(r"%%(time|timeit|capture|prun)\b", cell):
        return ""  # another language, or a file
    return "\n".join("" if line.lstrip().startswith(("%", "!", "?")) else line for line in lines)


def _parsed(cell: str) -> list[ast.stmt]:
    try:
        return _grammar(cell)
    except (SyntaxError, *UNREADABLE):
        return []  # a broken cell defines nothing; whoever asks says so


def _grammar(cell: str) -> list[ast.stmt]:
    """Statements of a cell that a notebook would run; parsing alone misses half of the errors."""
    code, flags = plain_code(cell), ast.PyCF_ALLOW_TOP_LEVEL_AWAIT
    tree = compile(code, "<cell>", "exec", flags | ast.PyCF_ONLY_AST, dont_inherit=True)
    compile(code, "<cell>", "exec", flags, dont_inherit=True)
    return tree.body


def _statements(cell: str) -> Iterator[tuple[ast.stmt, str]]:
    """Top-level statements of a cell and their text, decorators included."""
    lines = plain_code(cell).splitlines()
    for node in _parsed(cell):
        first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])
        yield node, "\n".join(lines[first - 1 : node.end_lineno])


def _names_a_function(node: ast.stmt, found: dict[str, str]) -> bool:
    """Whether a statement gives a name to a lambda, or another name to something defined."""
    if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name):
        return False
    value = node.value
    return isinstance(value, ast.Lambda) or (isinstance(value, ast.Name) and value.id in found)


def _constants(node: ast.stmt) -> list[str]:
    """Names that a statement gives a value to, if all are CONSTANTS."""
    targets = getattr(node, "targets", [getattr(node, "target", None)])
    if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
        return []
    names = [n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)]
    return names if all(name.isupper() for name in names) else []


def _is_import(text: str) -> bool:
    return text.startswith(("import ", "from "))


def _statement(name: str, value: Any) -> str | None:
    """The statement that gives a name its value in a live notebook."""
    if isinstance(value, types.ModuleType):
        return f"import {value.__name__} as {name}"
    home = getattr(value, "__module__", None)
    own_name = getattr(value, "__qualname__", "")
    if home == "__main__" and own_name and callable(value):
        return _live_source(name, value)
    if home and own_name.isidentifier() and callable(value):
        return f"from {home} import {own_name} as {name}"
    literal = _literal(value) if name.isupper() else None
    return None if literal is None else f"{name} = {literal}"


def _literal(value: Any) -> str | None:
    """Text that gives a plain value back, None for anything else."""
    if isinstance(value, np.generic):
        value = value.item()
    if type(value) is float and not math.isfinite(value):
        return f'float("{value}")'
    if type(value) is tuple:
        parts = [_literal(item) for item in value]
        return None if None in parts else f"({''.join(f'{part}, ' for part in parts)})"
    return repr(value) if type(value) in (int, float, str, bool, type(None)) else None


def _live_source(name: str, value: Any) -> str | None:
    """Source text of a function or class that was defined in a cell."""
    codes = [value.__code__] if hasattr(value, "__code__") else []
    codes += [v.__code__ for v in vars(value).values() if isinstance(v, types.FunctionType)]
    for code in codes:
        cell = "".join(linecache.getlines(code.co_filename))
        text = definition_in(cell, value.__name__)
        if text:
            other_name = "" if value.__name__ == name else f"\n\n\n{name} = {value.__name__}"
            return text + other_name
    try:
        return textwrap.dedent(inspect.getsource(value))
    except (OSError, TypeError):
        return None

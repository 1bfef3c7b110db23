"""From a student's function to a text that runs on its own.

The text holds the function, the helpers, imports and CONSTANTS it uses, and nothing else of the
notebook: a function that leans on a stray variable would not work in the robot, so the variable
is named instead. The same rules serve a live notebook and a notebook file.
"""

from __future__ import annotations

import ast
import builtins
import dis
import inspect
import linecache
import textwrap
import types
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

Lookup = Callable[[str], str | None]

LITERALS = (int, float, str, bool, tuple, type(None))


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
            missing.append(wanted)
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


def free_names(text: str) -> list[str]:
    """Names that a statement takes from outside itself, builtins left out, in order."""
    whole = compile("from __future__ import annotations\n" + text, "<text>", "exec")
    found: dict[str, None] = {}
    for code in _codes(whole):
        steps = list(dis.get_instructions(code))
        own = {step.argval for step in steps if step.opname == "STORE_NAME"}
        reads = [s.argval for s in steps if s.opname in ("LOAD_GLOBAL", "LOAD_NAME")]
        found |= dict.fromkeys(name for name in reads if name not in own)
    given = {*dir(builtins), "__name__", *(getattr(n, "name", "") for n in ast.parse(text).body)}
    return [name for name in found if name not in given]


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """A code object and all those inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def from_namespace(namespace: dict[str, Any]) -> Lookup:
    """Look names up in a live notebook."""

    def lookup(name: str) -> str | None:
        return _statement(name, namespace[name]) if name in namespace else None

    return lookup


def from_cells(cells: Iterable[str]) -> Lookup:
    """Look names up in the text of a notebook's code cells; the last definition counts."""
    found: dict[str, str] = {}
    for cell in cells:
        for node in _parsed(cell):
            text = _source_segment(cell, node)
            if isinstance(node, ast.Import | ast.ImportFrom):
                for alias in node.names:
                    found[alias.asname or alias.name.partition(".")[0]] = text
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                found[node.name] = text
            elif isinstance(node, ast.Assign) and _is_constant(node):
                found[node.targets[0].id] = text
    return found.get


def definition_in(cell: str, name: str) -> str | None:
    """The text of function or class ``name`` in a cell."""
    for node in _parsed(cell):
        if getattr(node, "name", None) == name and not isinstance(node, ast.ExceptHandler):
            return _source_segment(cell, node)
    return None


def plain_code(cell: str) -> str:
    """A cell without IPython's magics and shell lines, line numbers kept."""
    if cell.startswith("%%"):
        return ""
    lines = cell.splitlines()
    return "\n".join("" if line.lstrip().startswith(("%", "!", "?")) else line for line in lines)


def _parsed(cell: str) -> list[ast.stmt]:
    try:
        return ast.parse(plain_code(cell)).body
    except (SyntaxError, ValueError):
        return []  # a broken cell defines nothing; whoever asks says so


def _source_segment(cell: str, node: ast.stmt) -> str:
    first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])
    return "\n".join(plain_code(cell).splitlines()[first - 1 : node.end_lineno])


def _is_constant(node: ast.Assign) -> bool:
    target = node.targets[0]
    if len(node.targets) != 1 or not isinstance(target, ast.Name) or not target.id.isupper():
        return False
    try:
        ast.literal_eval(node.value)
    except ValueError:
        return False
    return True


def _is_import(text: str) -> bool:
    return text.startswith(("import ", "from "))


def _statement(name: str, value: Any) -> str | None:
    """The statement that gives a name its value in a live notebook."""
    if isinstance(value, types.ModuleType):
        return f"import {value.__name__} as {name}"
    home = getattr(value, "__module__", None)
    own_name = getattr(value, "__qualname__", "")
    if home == "__main__" and isinstance(value, types.FunctionType | type):
        return _live_source(value)
    if home and own_name.isidentifier() and callable(value):
        return f"from {home} import {own_name} as {name}"
    if name.isupper() and isinstance(value, LITERALS):
        return f"{name} = {value!r}"
    return None


def _live_source(value: Any) -> str | None:
    """Source text of a function or class that was defined in a cell."""
    codes = [value.__code__] if hasattr(value, "__code__") else []
    codes += [v.__code__ for v in vars(value).values() if isinstance(v, types.FunctionType)]
    for code in codes:
        cell = "".join(linecache.getlines(code.co_filename))
        text = definition_in(cell, value.__name__)
        if text:
            return text
    try:
        return textwrap.dedent(inspect.getsource(value))
    except (OSError, TypeError):
        return None

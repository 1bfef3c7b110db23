"""The far side: a process that holds a student's functions and answers calls.

It reads one request a line on standard input and writes one reply a line. The student's code
sees an empty standard input, and what it prints is kept up to a limit and handed back.
Requests: ``load`` (source and the names that must not be called), ``call``, ``run`` (cells).
"""

from __future__ import annotations

import io
import os
import shutil
import sys
import traceback
import types
from typing import Any, BinaryIO

from robocon_course.answers import wire

FILENAME = "<your answer>"
PRINT_LIMIT = 4000  # characters; a loop that prints must not fill the memory
MEMORY_LIMIT = 4 << 30  # bytes; numpy, numba and a drawing together stay below 1.2 GB


class NotYourOwn(Exception):
    """The answer calls the course's own version of the function it should be."""


class ChangedInput(Exception):
    """The answer changed an argument in place; in the robot somebody else still needs it."""


class Printed(io.TextIOBase):
    """Standard output of the student's code: the first characters are kept."""

    def __init__(self) -> None:
        self.text = ""

    def write(self, text: str) -> int:
        self.text += text[: PRINT_LIMIT - len(self.text)]
        return len(text)


class Closed:
    """An import hook: the exercises hold right and wrong answers, and no answer may read them."""

    def find_spec(self, name: str, *_: Any) -> None:
        """Refuse the room of the exercises; leave all other names to the next finder."""
        if name.startswith("robocon_course.exercises"):
            raise NotYourOwn("robocon_course.exercises")


def block(names: list[str]) -> None:
    """Make the course's own answers raise, wherever a module of the course holds them.

    A name is a function of a module, or a property of a class that would answer in its place.
    """
    for dotted in names:
        place, _, name = dotted.rpartition(".")
        module_name, _, class_name = place.rpartition(".")

        def refuse(*args: Any, _name: str = dotted, **kwargs: Any) -> None:
            raise NotYourOwn(_name)

        if class_name[:1].isupper():
            owner = getattr(__import__(module_name, fromlist=[class_name]), class_name)
            setattr(owner, name, property(refuse))
            continue
        original = getattr(__import__(place, fromlist=[name]), name)
        for module in [m for n, m in sys.modules.items() if n.startswith("robocon_course")]:
            if getattr(module, name, None) is original:
                setattr(module, name, refuse)


def failure(error: BaseException, source: str) -> dict[str, Any]:
    """What the judge may know of an exception: its kind, its words, the line it came from."""
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == FILENAME]
    if isinstance(error, SyntaxError) and error.filename == FILENAME:
        lines.append(error.lineno)
    text = source.splitlines()
    line = text[lines[-1] - 1].strip() if lines and lines[-1] and lines[-1] <= len(text) else ""
    return {"error": type(error).__name__, "message": str(error)[:1000], "line": line}


class Worker:
    """Holds the namespace between requests."""

    def __init__(self) -> None:
        self.names: dict[str, Any] = {}
        self.source = ""

    def load(self, source: str, blocked: list[str]) -> None:
        """Run the answer's definitions in a fresh namespace."""
        # A module that is known by its name: a data class looks itself up there.
        module = sys.modules["answer"] = types.ModuleType("answer")
        self.source, self.names = source, vars(module)
        block(blocked)
        if not any(isinstance(finder, Closed) for finder in sys.meta_path):
            sys.meta_path.insert(0, Closed())
        exec(compile(source, FILENAME, "exec"), self.names)

    def call(self, name: str, args: tuple) -> Any:
        """Call one of the functions that were loaded; what it was given must stay as it was."""
        given = wire.dumps(args)
        value = self.names[name](*args)
        if wire.dumps(args) != given:
            raise ChangedInput(name)
        return value

    def run(self, cells: list[str], student: int | str, references: dict[str, str]) -> list:
        """Run a notebook's cells and return what it passed to ``answer``."""
        from robocon_course.answers import rehearsal

        return rehearsal.run(cells, student, references)

    def reply(self, request: dict[str, Any]) -> dict[str, Any]:
        """Carry out one request; whatever the student's code raises becomes part of the reply."""
        printed = sys.stdout = Printed()
        sys.stderr = Printed()  # warnings of libraries are no news of the student's
        try:
            action = getattr(self, request.pop("do"))
            reply = {"value": action(**request)}
        except BaseException as error:  # SystemExit and KeyboardInterrupt included
            reply = failure(error, self.source)
        return reply | {"printed": printed.text}


def limit_memory() -> None:
    """Bound the memory of this process where the system can (Linux and other Unixes)."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except (ImportError, ValueError, OSError):
        pass  # Windows has no such limit; the wall-clock limit still holds


def private_pipes() -> tuple[BinaryIO, BinaryIO]:
    """Move the protocol off standard input and output, where students' code reads and prints."""
    requests, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(nothing, standard)
    sys.stdin = open(os.devnull)
    return requests, replies


def main() -> None:
    """Serve requests until the other side closes the pipe.

    The folder given as argument is this process's own; it goes with it, also when the other
    side was killed and could not clear it away.
    """
    limit_memory()
    requests, replies = private_pipes()
    worker = Worker()
    replies.write(wire.READY)
    replies.flush()
    for line in requests:
        reply = worker.reply(wire.loads(line))
        try:
            replies.write(wire.dumps(reply))
        except (RecursionError, MemoryError, ValueError) as error:
            replies.write(wire.dumps(failure(error, "") | {"printed": ""}))
        replies.flush()
    for folder in sys.argv[1:]:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()

"""The near side of an answer: start its process, ask it, and wait no longer than allowed."""

from __future__ import annotations

import hashlib
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from robocon_course.answers import wire
from robocon_course.files import LARGEST_WEIGHTS, PACKAGE, checksums

REPLY_LIMIT = 64 << 20  # bytes; an answer that returns more than this is told so
START_LIMIT = 60.0  # s; a cold disk and a busy laptop need some of it


@dataclass(frozen=True)
class Reply:
    """What came back from one call: a value, or the kind and words of an exception.

    ``error`` is the exception's type name, ``"TimeLimit"`` when the process was stopped,
    ``"ProcessEnded"`` when it died, and empty when a value came.
    ``seconds`` is how long one waited for it; no two runs agree on that.
    """

    value: Any = None
    error: str = ""
    message: str = ""
    line: str = ""
    printed: str = ""
    seconds: float = field(default=0.0, compare=False)


class AnswerProcess:
    """One fresh process with one student's code; usable as a context manager.

    Parameters
    ----------
    time_limit : float  [s]
        Wall-clock time for ``load`` and all calls together. Start-up is not counted.
    """

    def __init__(self, time_limit: float = 10.0) -> None:
        self.time_left = time_limit
        self.time_limit = time_limit
        self._folder = tempfile.TemporaryDirectory(prefix="answer-", ignore_cleanup_errors=True)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "robocon_course.answers.worker", self._folder.name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=self._folder.name,
            env=_environment(),
            start_new_session=True,  # so that its children end with it
        )
        self._ready = self._closed = False
        self._requests: queue.Queue[bytes | None] = queue.Queue()
        self._lines: queue.Queue[bytes] = queue.Queue()
        for pipe in (self._write, self._read):
            threading.Thread(target=pipe, daemon=True).start()

    def allow(self, time_limit: float) -> None:
        """Set the time for what follows, in seconds."""
        self.time_limit = self.time_left = time_limit

    def load(self, source: str, blocked: tuple[str, ...] = ()) -> Reply:
        """Define the answer's functions; ``blocked`` are course functions it must not call."""
        return self._ask(do="load", source=source, blocked=list(blocked))

    def give(self, path: Path, name: str) -> str:
        """Lay a copy of a file into the folder that the answer runs in.

        Parameters
        ----------
        path : Path
        name : str

        Returns
        -------
        str
            Why it was left away: a link, no plain file, too large, the course's own. Empty where it
            was copied, and where there is none: the answer may not have come so far.
        """
        try:
            if path.is_symlink():
                return "is a link; hand in the file itself"
            if path.exists() and not path.is_file():
                return "is not a file"
            if not path.exists():
                return ""
            if path.stat().st_size > LARGEST_WEIGHTS:
                size = path.stat().st_size / 1e6
                return f"has {size:.1f} MB, and {LARGEST_WEIGHTS / 1e6:g} MB are allowed"
            data = path.read_bytes()
            if hashlib.sha256(data).hexdigest() in checksums("weights").values():
                return "is the network that the course came with; hand in one of your own training"
            (Path(self._folder.name) / name).write_bytes(data)
        except OSError as error:
            return f"cannot be read ({error.strerror})"
        return ""

    def call(self, name: str, args: tuple = ()) -> Reply:
        """Call function ``name`` of the answer."""
        return self._ask(do="call", name=name, args=args)

    def run(self, cells: list[str], student: int | str, references: dict[str, str]) -> Reply:
        """Run a notebook's cells; the value lists the numbers it passed to ``answer``."""
        return self._ask(do="run", cells=cells, student=student, references=references)

    def close(self) -> None:
        """End the process and its group; a child that left the group keeps nothing waiting."""
        if self._closed:
            return  # its number may be another process's by now
        self._closed = True
        self._requests.put(None)
        if os.name == "posix":
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._process.wait()
        self._folder.cleanup()

    def __enter__(self) -> AnswerProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write(self) -> None:
        """Send requests; only this thread waits for a process that does not read them."""
        with suppress(OSError, ValueError), self._process.stdin as pipe:
            while (request := self._requests.get()) is not None:
                pipe.write(request)
                pipe.flush()

    def _read(self) -> None:
        """Collect reply lines; an over-long or last empty one ends the collection."""
        line = b"start"
        with suppress(OSError, ValueError), self._process.stdout as pipe:
            while line and len(line) <= REPLY_LIMIT:
                line = pipe.readline(REPLY_LIMIT + 1)
                self._lines.put(line)
        self._lines.put(b"")

    def _ask(self, **request: Any) -> Reply:
        ended = Reply(error="ProcessEnded", message="the process that ran your code ended")
        if self._closed:
            return ended
        try:
            if not self._ready:  # the interpreter's own start is not the answer's time
                self._ready = self._lines.get(timeout=START_LIMIT) == wire.READY
            started = time.monotonic()
            self._requests.put(wire.dumps(request))
            line = self._lines.get(timeout=max(self.time_left, 0.0))
        except queue.Empty:
            self.close()
            return Reply(error="TimeLimit", message=f"stopped after {self.time_limit:g} s")
        waited = time.monotonic() - started
        self.time_left -= waited
        if len(line) > REPLY_LIMIT:
            return Reply(error="TooLarge", message=f"returned more than {REPLY_LIMIT >> 20} MB")
        return replace(_reply(line), seconds=waited) if line else ended


def _reply(line: bytes) -> Reply:
    try:
        reply = Reply(**wire.loads(line))
    except (ValueError, TypeError) as error:
        return Reply(error="NotPlainData", message=str(error))
    words = (reply.error, reply.message, reply.line, reply.printed)
    if not all(isinstance(word, str) for word in words):
        return Reply(error="NotPlainData", message="a reply that no answer gives")
    return reply


# What a Python program needs of its surroundings; a grader's tokens and folders are not part of it.
PASSED_ON = (
    *("PATH", "LANG", "LC_ALL", "LC_CTYPE", "TZ", "LD_LIBRARY_PATH", "VIRTUAL_ENV"),
    *("SYSTEMROOT", "WINDIR", "COMSPEC", "PATHEXT", "TEMP", "TMP", "TMPDIR"),
    *("NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT", "COVERAGE_PROCESS_START"),
)


def _environment() -> dict[str, str]:
    """One thread per process: faster for small arrays, and the same sums everywhere."""
    threads = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    # The worker must find the package even where it was put on the path by hand.
    paths = [str(PACKAGE.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    kept = {name: os.environ[name] for name in PASSED_ON if name in os.environ}
    own = {"PYTHONPATH": os.pathsep.join(paths), "MPLBACKEND": "Agg"}
    return kept | dict.fromkeys(threads, "1") | own

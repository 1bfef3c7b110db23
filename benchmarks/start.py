"""How long does a student wait: for the package to load, and for the first verdict?

    python benchmarks/start.py

Every measurement is a fresh process. Kernels start with an empty compiler cache and an empty
workspace, and get the cells of chapter 01 one after the other, without a pause to read: the worst
case. Medians of wall-clock times; compare on an idle machine.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

import nbformat
from jupyter_client import BlockingKernelClient, KernelManager

CHAPTER = Path(__file__).resolve().parents[1] / "solutions" / "01_imu.ipynb"
IMPORTS = 7
KERNELS = 5
PATIENCE = 120  # s


def import_time(statement: str) -> float:
    """Median seconds that a statement takes in a fresh process that has imported numpy."""
    clock = "time.perf_counter()"
    code = f"import time, numpy; start = {clock}; {statement}; print({clock} - start)"
    command = [sys.executable, "-c", code]
    return median(float(subprocess.check_output(command)) for _ in range(IMPORTS))


@contextmanager
def cold_kernel() -> Iterator[BlockingKernelClient]:
    """A kernel that has compiled nothing yet, in a workspace that holds nothing."""
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        kernel = KernelManager(kernel_name="python3")
        empty = {"NUMBA_CACHE_DIR": f"{folder}/numba", "ROBOCON_WORKSPACE": f"{folder}/work"}
        kernel.start_kernel(cwd=folder, env=os.environ | empty, stderr=subprocess.DEVNULL)
        client = kernel.client()
        client.start_channels()
        try:
            client.wait_for_ready(timeout=PATIENCE)
            yield client
            assert any(Path(folder, "numba").rglob("*.nbi")), "nothing was compiled"
        finally:
            client.stop_channels()
            kernel.shutdown_kernel(now=True)


def seconds(client: BlockingKernelClient, source: str, wanted: str = "") -> float:
    """Time from sending a cell to its reply; the cell must show what is wanted."""
    shown: list[str] = []

    def keep(message: dict) -> None:
        content = message["content"]
        shown.append(content.get("text") or content.get("data", {}).get("text/plain", ""))

    start = perf_counter()
    reply = client.execute_interactive(source, timeout=PATIENCE, output_hook=keep)
    elapsed = perf_counter() - start
    assert reply["content"]["status"] == "ok", reply["content"]
    assert wanted in "".join(shown), shown
    return elapsed


def first_check() -> tuple[float, float, float]:
    """Set-up cells, the first check, and the same check again, in a cold kernel [s]."""
    cells = {cell.id: cell.source for cell in nbformat.read(CHAPTER, as_version=4).cells}
    begin = next(source for source in cells.values() if "begin(" in source)
    functions = [cells[f"exercise-imu-{name}"] for name in ("gravity_direction", "mahony_step")]
    check, passed = cells["check-imu-mahony_step"], "✔ passed: imu.mahony_step"
    with cold_kernel() as client:
        before = sum(seconds(client, source) for source in (begin, *functions))
        return before, seconds(client, check, passed), seconds(client, check, passed)


def main() -> None:
    """Print what was measured, beside what is wanted."""
    package = import_time("import robocon_course")
    chapter = import_time("from robocon_course import imu")
    print(f"after numpy, median of {IMPORTS} fresh processes")
    print(f"  import robocon_course           {package:6.3f} s    wanted < 0.1")
    print(f"  from robocon_course import imu  {chapter:6.3f} s    numba's own import included\n")
    runs = [first_check() for _ in range(KERNELS)]
    before, first, again = (median(times) for times in zip(*runs, strict=True))
    print(f"chapter 01 in a cold notebook, median of {KERNELS} fresh kernels and compiler caches")
    print(f"  set-up cell and two functions   {before:6.2f} s")
    print(f"  first check                     {first:6.2f} s    wanted < 3")
    print(f"  both together                   {before + first:6.2f} s")
    print(f"  the same check again            {again:6.2f} s")


if __name__ == "__main__":
    main()

"""How many pictures does the synthetic camera draw, and in how much memory?

    python benchmarks/pictures.py

Pictures of 320 x 240 on one core, in CPU time; then a data set drawn by all cores, while the
memory of all its processes is added up (proportional set size: shared pages once; Linux only).
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
from pathlib import Path

from robocon_course.vision.dataset import write_dataset
from robocon_course.vision.pictures import picture

COUNT = 60
SET = 400


def drawn_per_second(kind: str) -> float:
    """Pictures in a second of CPU time, the first left out: it compiles."""
    picture(kind, 1, 0)
    started = time.process_time()
    for index in range(COUNT):
        picture(kind, 2, index)
    return COUNT / (time.process_time() - started)


def family(pid: int) -> list[int]:
    """A process and all that it started."""
    try:
        listed = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return [pid]
    return [pid, *(one for child in listed for one in family(int(child)))]


def memory() -> float:
    """Of this process and its children [MB]."""
    total = 0
    for pid in family(os.getpid()):
        try:
            lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
        except OSError:
            continue
        total += sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return total / 1000.0


def most_memory(images: int) -> tuple[float, float]:
    """Largest memory while a data set is drawn [MB], and seconds."""
    most, done = [0.0], threading.Event()

    def watch() -> None:
        while not done.wait(0.2):
            most[0] = max(most[0], memory())

    threading.Thread(target=watch, daemon=True).start()
    with tempfile.TemporaryDirectory() as place:
        started = time.perf_counter()
        write_dataset("ball", Path(place) / "set", images, 3, size=(320, 240))
        seconds = time.perf_counter() - started
    done.set()
    return most[0], seconds


def main() -> None:
    for kind in ("ball", "silo"):
        print(f"{kind}: {drawn_per_second(kind):.0f} pictures a second and core (30 wanted)")
    if Path("/proc/self/smaps_rollup").exists():
        small, _ = most_memory(SET // 4)
        large, seconds = most_memory(SET)
        print(f"a set of {SET // 4}: {small:.0f} MB; of {SET}: {large:.0f} MB in {seconds:.0f} s")
        growth = (large - small) / (SET - SET // 4)
        print(f"10,000 pictures at that growth: {large + growth * (10_000 - SET):.0f} MB")


if __name__ == "__main__":
    main()

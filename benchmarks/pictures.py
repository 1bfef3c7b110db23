"""How many pictures does the synthetic camera draw, and in how much memory?

    python benchmarks/pictures.py

Pictures of 320 x 240 on one core, in CPU time; then data sets drawn by `robocon dataset`, while
the memory of all its processes is added up (proportional set size: shared pages once; Linux only).
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from robocon_course.vision.pictures import picture

COUNT = 60
SET = 1000


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


def memory(pid: int) -> float:
    """Of a process and all that it started [MB]."""
    total = 0
    for one in family(pid):
        try:
            lines = Path(f"/proc/{one}/smaps_rollup").read_text().splitlines()
        except OSError:
            continue
        total += sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return total / 1000.0


def most_memory(images: int) -> tuple[float, float]:
    """Largest memory while a data set is drawn by the command, all processes [MB], and seconds."""
    command = [sys.executable, "-m", "robocon_course.cli", "dataset", "ball", "--seed", "3"]
    with tempfile.TemporaryDirectory() as place:
        started, most = time.perf_counter(), 0.0
        run = subprocess.Popen(
            [*command, "--images", str(images), "--out", str(Path(place) / "set")],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        while run.poll() is None:
            most = max(most, memory(run.pid))
            time.sleep(0.2)
        assert run.returncode == 0, "robocon dataset failed; call it by hand to see why"
    return most, time.perf_counter() - started


def main() -> None:
    for kind in ("ball", "silo"):
        print(f"{kind}: {drawn_per_second(kind):.0f} pictures a second and core (30 wanted)")
    if Path("/proc/self/smaps_rollup").exists():
        small, _ = most_memory(SET // 4)
        large, seconds = most_memory(SET)
        print(f"a set of {SET // 4}: {small:.0f} MB; of {SET}: {large:.0f} MB in {seconds:.0f} s")
        growth = max(0.0, large - small) / (SET - SET // 4)
        most = large + growth * (10_000 - SET)
        print(f"10,000 pictures at that growth: {most:.0f} MB (500 wanted at most)")


if __name__ == "__main__":
    main()

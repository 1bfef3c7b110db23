"""Is this computer ready? One line per thing that matters, and the exact command that mends it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata

OPENCV = (
    "opencv-python",
    "opencv-python-headless",
    "opencv-contrib-python",
    "opencv-contrib-python-headless",
)
CORE = ("jupyterlab", "ipykernel", "numpy", "numba", "matplotlib", "ipywidgets", "onnxruntime")
VISION = ("ultralytics-opencv-headless", "torch", "torchvision", "onnx")
PIP = f'"{sys.executable}" -m pip'  # of this very environment, whatever the PATH says
PAIRS = {"2.13": "0.28", "2.12": "0.27"}  # torch -> the torchvision built for it


@dataclass(frozen=True)
class Line:
    """One thing looked at: is it well, what was seen, and what to type if not."""

    name: str
    well: bool
    seen: str
    fix: str = ""


def examine() -> Iterator[Line]:
    """Look at everything, one line at a time."""
    version = ".".join(map(str, sys.version_info[:3]))
    yield Line("python", sys.version_info >= (3, 11), version, "install Python 3.11 or newer")
    for name in CORE:
        yield _package(name)
    yield _opencv()
    yield _kernel()
    yield from _vision()


def verdict(lines: list[Line]) -> str:
    """The one line that sums up: well, or the first thing to mend and how."""
    ill = [line for line in lines if not line.well]
    if not ill:
        return "All is well. Open the course with: robocon lab"
    first = ill[0]
    more = f" ({len(ill) - 1} more after that)" if len(ill) > 1 else ""
    return f"{first.name}: {first.seen}. Mend it with: {first.fix}{more}"


def summary() -> str:
    """The verdict in one line, for the first cell of a notebook."""
    return verdict(list(examine()))


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _package(name: str) -> Line:
    found = _version(name)
    return Line(name, found is not None, found or "not installed", _cure(name))


def _cure(name: str) -> str:
    """The command that installs a package in the version that the course asks for."""
    try:
        wanted = [need.partition(";")[0].strip() for need in metadata.requires("robocon-course")]
    except (metadata.PackageNotFoundError, TypeError):
        wanted = []
    asked = next((need for need in wanted if re.match(rf"{name}(?![\w-])", need)), name)
    return f'{PIP} install "{asked}"'


def _opencv() -> Line:
    """Several distributions provide one module cv2; the last one installed wins, in part."""
    found = [name for name in OPENCV if _version(name)]
    seen = ", ".join(f"{name} {_version(name)}" for name in found) or "not installed"
    if found == ["opencv-python-headless"]:
        return Line("cv2", True, seen)
    remove = f"{PIP} uninstall -y {' '.join(found)} && " if found else ""
    fix = f"{remove}{PIP} install --force-reinstall --no-deps opencv-python-headless"
    seen = f"{len(found)} distributions of one module: {seen}" if len(found) > 1 else seen
    return Line("cv2", False, seen, fix)


def _kernel() -> Line:
    """The kernel that notebooks ask for must be this very Python."""
    fix = f'"{sys.executable}" -m ipykernel install --sys-prefix --name python3'
    try:
        from jupyter_client.kernelspec import KernelSpecManager

        spec = KernelSpecManager().get_kernel_spec("python3")
    except Exception as error:
        return Line("kernel", False, f"no kernel python3 ({type(error).__name__})", fix)
    program = spec.argv[0] if spec.argv else ""
    same = program in ("python", "python3") or _prefix(program) == sys.prefix
    return Line("kernel", same, f"python3 runs {program}", fix)


def _prefix(program: str) -> str:
    """The environment that a Python program belongs to."""
    if program == sys.executable:
        return sys.prefix
    ask = [program, "-c", "import sys, json; print(json.dumps(sys.prefix))"]
    try:
        done = subprocess.run(ask, capture_output=True, text=True, timeout=20)
        return str(json.loads(done.stdout))
    except (OSError, ValueError, subprocess.SubprocessError):
        return ""


def _vision() -> Iterator[Line]:
    """Only training in chapter 06 needs these; their absence is no illness."""
    found = {name: _version(name) for name in VISION}
    if not any(found.values()):
        yield Line(
            "vision", True, 'not installed; training in chapter 06 needs pip install -e ".[vision]"'
        )
        return
    for name in VISION:
        yield _package(name)
    torch, vision = (found[n] or "" for n in ("torch", "torchvision"))
    wanted = PAIRS.get(".".join(torch.split(".")[:2]))
    if torch and vision and wanted and not vision.startswith(f"{wanted}."):
        seen = f"torch {torch} with torchvision {vision}, which was built for another torch"
        yield Line("torch pair", False, seen, f'{PIP} install "torchvision~={wanted}.0"')

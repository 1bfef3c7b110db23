"""Benchmark maps of the Moving AI Lab: a text with one letter a cell, and pairs to plan between.

A ``.map`` file has four lines of header, then one line for each row, the largest y first:

    type octile
    height 3
    width 4
    map
    ..@@
    ....
    T..@

Cells with ``.``, ``G`` and ``S`` are free, those with ``@``, ``O``, ``T`` and ``W`` are not. A
``.scen`` file beside it has one line for each pair of points, with the length of the shortest way
that takes a diagonal step only where both cells beside it are free. The files know no metres: a
cell is 1 m wide here, and the map begins at (0, 0).

Source: N. Sturtevant, Benchmarks for Grid-Based Pathfinding, IEEE Transactions on Computational
Intelligence and AI in Games 4(2), 2012; https://movingai.com/benchmarks/formats.html.
"""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

from robocon_course.gridmap.grid import BoolArray, GridMap

PASSABLE, BLOCKED = ".GS", "@OTW"
NUMBERS = 7  # at the end of a scenario's line: width, height, start x, y, goal x, y, length


class Scenario(NamedTuple):
    """Two points, and how long the shortest way between them is.

    Attributes
    ----------
    start, goal : (float, float)  [m, map]
        Middles of their cells.
    length : float  [m]
    """

    start: tuple[float, float]
    goal: tuple[float, float]
    length: float


def load_octile(path: Path) -> GridMap:
    """The map of a ``.map`` file, in cells of 1 m.

    Parameters
    ----------
    path : Path
        An existing file.

    Returns
    -------
    GridMap

    Raises
    ------
    ValueError
        No such header, a row of another width, too few or too many rows, or another letter.
    """
    lines = _lines(path)
    head = [line.split() for line in lines[:4]]
    about = {words[0]: words[1] for words in head[:3] if len(words) == 2}
    if head[3:] != [["map"]] or about.get("type") != "octile":
        raise ValueError(
            f"{path}: is no map of the Moving AI Lab; its first lines must be "
            "'type octile', 'height ...', 'width ...' and 'map'"
        )
    height, width = (_count(about, key, path) for key in ("height", "width"))
    rows = lines[4:]
    if len(rows) != height:
        raise ValueError(f"{path}: holds {len(rows)} rows, but says height {height}; is it whole?")
    for number, row in enumerate(rows, start=5):
        if len(row) != width:
            raise ValueError(
                f"{path}: line {number} holds {len(row)} cells, but the file says width {width}"
            )
    return GridMap(_free("".join(rows), (height, width), path)[::-1], 1.0)


def load_scenarios(path: str | Path, grid: GridMap) -> list[Scenario]:
    """The pairs of points of a ``.scen`` file.

    Parameters
    ----------
    path : str or Path
    grid : GridMap
        The map they belong to. It may have been given another resolution and origin than
        `load_map` gives it; points and lengths follow it.

    Returns
    -------
    list of Scenario
        In the order of the file.

    Raises
    ------
    FileNotFoundError
        No such file.
    ValueError
        A line that makes no sense, or a map of another size.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"there is no file {path}; give the .scen file of the map")
    head, *lines = _lines(path) or [""]
    if not head.startswith("version"):
        raise ValueError(f"{path}: must begin with a line 'version 1', not with {head[:40]!r}")
    found = []
    for number, line in enumerate(lines, start=2):
        try:
            if line:
                found.append(_scenario(line, grid))
        except ValueError as error:
            raise ValueError(f"{path}: line {number} {error}") from None
    return found


def _lines(path: Path) -> list[str]:
    """A file's lines without what ends them, and without the empty ones at its end."""
    try:
        text = path.read_text(encoding="utf-8-sig")  # which knows the ends of lines of all systems
    except UnicodeDecodeError:
        raise ValueError(f"{path}: is no text; is it the right file?") from None
    return [line.rstrip() for line in text.rstrip().split("\n")]


def _count(about: dict[str, str], key: str, path: Path) -> int:
    """The number of rows or columns."""
    text = about.get(key, "")
    if not text.isdecimal() or not int(text):
        raise ValueError(f"{path}: {key} must be a positive whole number, got {text!r}")
    return int(text)


def _free(cells: str, shape: tuple[int, int], path: Path) -> BoolArray:
    """Which cells are passable, the file's way up."""
    unknown = sorted(set(cells) - set(PASSABLE + BLOCKED))
    if unknown:
        raise ValueError(
            f"{path}: {unknown[0]!r} is no letter for a cell; free are . G S, blocked are @ O T W"
        )
    letters = np.frombuffer(cells.encode("ascii"), np.uint8).reshape(shape)
    return np.isin(letters, list(PASSABLE.encode()))


def _scenario(line: str, grid: GridMap) -> Scenario:
    """One pair; x counts columns from the left, y counts rows from the top."""
    words = line.split()[-NUMBERS:]  # before them the bucket and the map's name, spaces and all
    try:
        cols, rows, x0, y0, x1, y1 = (int(word) for word in words[:-1])
        length = float(words[-1])
        if not 0.0 <= length < inf:
            raise ValueError
    except ValueError:
        raise ValueError(f"is no pair of points: {line[:60]!r}") from None
    if (rows, cols) != grid.shape:
        here = "{} x {}".format(*grid.shape)
        raise ValueError(f"belongs to a map of {rows} x {cols} cells, but this one has {here}")
    ends = np.array([[rows - 1 - y0, x0], [rows - 1 - y1, x1]])
    if not ((ends >= 0) & (ends < grid.shape)).all():
        raise ValueError(f"names a cell outside the map: {line[:60]!r}")
    start, goal = grid.centres(ends).tolist()
    return Scenario(tuple(start), tuple(goal), length * grid.resolution)

"""Where the course's own files lie: inside the wheel, or at the top of a checkout."""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
CHECKOUT = PACKAGE.parent


def in_checkout() -> bool:
    """Whether the package runs from a checkout (lessons and data beside it)."""
    return (CHECKOUT / "solutions").is_dir() and (CHECKOUT / "pyproject.toml").is_file()


def data_file(name: str) -> Path:
    """Path of a data file of the course, ``"imu/still.csv"`` for instance.

    Raises
    ------
    FileNotFoundError
        No such file; the message says which name was looked for.
    """
    for root in (PACKAGE / "_data", CHECKOUT / "data"):
        if (root / name).exists():
            return root / name
    raise FileNotFoundError(f"the course has no data file {name!r}; install the package again")


LARGEST_WEIGHTS = 13_000_000
"""No file of weights is larger, the course's own or a student's [bytes]."""


def checksums(folder: str) -> dict[str, str]:
    """SHA-256 of the data files of one folder, by name, as ``sha256sum`` writes them.

    Raises
    ------
    FileNotFoundError
        The folder has no SHA256SUMS.
    ValueError
        It is not text.
    """
    listed = data_file(f"{folder}/SHA256SUMS").read_text(encoding="ascii")
    lines = (line.split() for line in listed.splitlines())
    return {line[1].lstrip("*"): line[0] for line in lines if len(line) == 2}


def lessons_folder() -> Path:
    """Folder with the pristine student notebooks."""
    packed = PACKAGE / "_lessons"
    return packed if packed.is_dir() else CHECKOUT / "notebooks"

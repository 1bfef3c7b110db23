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


def lessons_folder() -> Path:
    """Folder with the pristine student notebooks."""
    packed = PACKAGE / "_lessons"
    return packed if packed.is_dir() else CHECKOUT / "notebooks"

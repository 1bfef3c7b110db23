"""What every test may ask for. Missing equipment skips a test, and fails it under CI=true."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def missing(what: str) -> None:
    """Skip with the reason; on the build server a missing thing is a failure."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what} (with CI=true this is a failure)")
    pytest.skip(what)


@pytest.fixture(scope="session")
def recordings() -> Path:
    """Folder with other people's recordings, which the project reads and never contains."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        missing(f"no recordings at {folder}")
    return folder

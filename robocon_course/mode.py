"""Whether the course runs for a person or for a test."""

from __future__ import annotations

import os


def running_as_test() -> bool:
    """True where loops should be short: environment variable ``ROBOCON_TEST``, or nbgrader.

    Both modes reach the same verdicts; only the length of demonstrations differs.
    """
    return bool(os.environ.get("ROBOCON_TEST") or os.environ.get("NBGRADER_EXECUTION"))

"""Each lesson that pytest runs gets a workspace of its own, and leaves none beside the lessons.

Otherwise an accepted answer would be version 2 the next day, and a student number that somebody
gave long ago would change the numbers.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

WORKSPACES = pytest.StashKey[Path]()
collect_ignore_glob = ["notebooks/*.kept-*.ipynb"]  # set aside by `robocon reset`


def pytest_configure(config: pytest.Config) -> None:
    os.environ.setdefault("ROBOCON_TEST", "1")  # lessons cut long trainings short
    config.option.nbval_sanitize_with = str(config.rootpath / "tests" / "nbval.cfg")
    folder = TemporaryDirectory(prefix="lessons-", ignore_cleanup_errors=True)
    config.stash[WORKSPACES] = Path(folder.name)
    config.add_cleanup(folder.cleanup)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    """The kernel of a lesson starts in the set-up of its first cell, and inherits this."""
    if item.path.suffix != ".ipynb":
        return (yield)
    workspace = item.config.stash[WORKSPACES] / item.path.parent.name / item.path.stem
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROBOCON_WORKSPACE", str(workspace))
        return (yield)

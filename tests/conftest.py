"""What every test may ask for. Missing equipment skips a test, and fails it under CI=true."""

from __future__ import annotations

import importlib.util
import os
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import pytest
from hypothesis import settings

# The build server tries the same numbers every time; people's machines look for new ones. Nobody's
# machine fails a test for being busy.
settings.register_profile("people", deadline=None)
settings.register_profile("server", derandomize=True, deadline=None)
settings.load_profile("people")
if os.environ.get("CI") == "true":
    settings.load_profile("server")

ROOT = Path(__file__).resolve().parents[1]


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """A campaign that takes no sample of itself waits for ``-m campaign``."""
    if asked_for_campaigns(config):
        return
    waiting = [
        item
        for item in items
        if item.get_closest_marker("campaign") and "whole" not in getattr(item, "fixturenames", ())
    ]
    config.hook.pytest_deselected(items=waiting)
    items[:] = [item for item in items if item not in waiting]


def asked_for_campaigns(config: pytest.Config) -> bool:
    """Whether the long runs are to be run whole."""
    return "campaign" in config.option.markexpr


@pytest.fixture
def whole(request: pytest.FixtureRequest) -> bool:
    """Whether a campaign runs whole; else it takes a sample of itself."""
    return asked_for_campaigns(request.config)


def missing(what: str) -> None:
    """Skip with the reason; on the build server a missing thing is a failure."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what} (with CI=true this is a failure)")
    pytest.skip(what)


@cache
def benchmark(name: str) -> ModuleType:
    """A script of benchmarks/, to call what it measures."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "benchmarks" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def recordings() -> Path:
    """Folder with other people's recordings, which the project reads and never contains."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        missing(f"no recordings at {folder}")
    return folder


@cache
def solved_parts() -> Any:
    """The parts that a student has who solved every lesson as its solution does, plain Python."""
    from robocon_course import lessons
    from robocon_course.exercises import registry, robot_parts
    from robocon_course.exercises.model import Exercise
    from robocon_course.exercises.source import assemble, from_cells
    from robocon_course.exercises.workspace import Workspace

    with TemporaryDirectory() as folder:
        workspace = Workspace(folder)
        for about in registry.chapters():
            source = lessons.read_source(ROOT / "solutions" / f"{about.name}.py")
            cells = [cell.source for cell in source.cells if cell.cell_type == "code"]
            for exercise in about.exercises:
                if isinstance(exercise, Exercise):
                    answer = assemble(exercise.function_name, from_cells(cells))
                    workspace.accept(exercise.id, answer.text)
        return robot_parts("mine", workspace=workspace)

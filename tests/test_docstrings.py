"""Docstrings: everything public has one, it agrees with the code, and its examples run."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil
import re
from functools import cache

import pytest

import robocon_course
from robocon_course import exercises, view

MODULES = [info.name for info in pkgutil.walk_packages(robocon_course.__path__, "robocon_course.")]
# What students and their robots call; there every argument has its shape and unit in words.
ROOMS = (
    *("geometry", "gridmap", "drivetrain", "raycast", "field", "imu", "odometry", "swerve"),
    *(
        "planning",
        "tracking",
        "robot",
        "simulator",
        "autopilot",
        "logs.writer",
        "logs.reader",
        "logs.replay",
        "recordings",
    ),
)


def is_code(value) -> bool:
    """Whether a docstring belongs on it: a function, compiled or not, or a class."""
    return inspect.isfunction(value) or inspect.isclass(value) or hasattr(value, "py_func")


@cache
def public() -> dict[str, object]:
    """Every public function, class and method of the package, by its dotted name."""
    found = {}
    for module_name in MODULES:
        module = importlib.import_module(module_name)
        for name, value in vars(module).items():
            if name.startswith("_") or getattr(value, "__module__", None) != module_name:
                continue
            if not is_code(value):
                continue
            found[f"{module_name}.{name}"] = value
            if inspect.isclass(value):
                for method, inner in vars(value).items():
                    if not method.startswith("_") and isinstance(
                        inner, property | staticmethod | classmethod | type(is_code)
                    ):
                        found[f"{module_name}.{name}.{method}"] = inner
    return found


def section(value, title: str) -> list[str] | None:
    """Names that a numpydoc section lists, None without such a section."""
    text = inspect.getdoc(value) or ""
    rule = rf"^{title}\n-+\n(.*?)(?=^\w[^\n]*\n-{{3,}}\n|\Z)"
    match = re.search(rule, text, re.MULTILINE | re.DOTALL)
    if match is None:
        return None
    heads = [line.split(" : ")[0] for line in match[1].splitlines() if line[:1].strip()]
    return [name.strip().lstrip("*") for head in heads for name in head.split(",")]


def parameters(value) -> list[str]:
    """Names in the signature of a function or class."""
    try:
        names = inspect.signature(getattr(value, "py_func", value)).parameters
    except (TypeError, ValueError):
        return []
    return [name for name in names if name != "self"]


FUNCTIONS = {name: value for name, value in public().items() if callable(value)}


def test_there_is_something_to_look_at():
    assert len(MODULES) > 30 and len(public()) > 150


@pytest.mark.parametrize("name", MODULES)
def test_every_module_says_what_it_is_for(name):
    assert len(importlib.import_module(name).__doc__ or "") > 20


@pytest.mark.parametrize("name", public())
def test_everything_public_says_what_it_does(name):
    value = public()[name]
    first = (inspect.getdoc(value) or "").strip().splitlines()[:1]
    assert first and len(first[0]) > 10, f"{name} has no docstring"
    if inspect.isclass(value):  # a data class without one shows its signature instead
        assert not first[0].startswith(f"{value.__name__}("), f"{name} has no docstring"


@pytest.mark.parametrize("name", [n for n, v in FUNCTIONS.items() if section(v, "Parameters")])
def test_the_parameters_described_are_those_of_the_signature(name):
    assert section(FUNCTIONS[name], "Parameters") == parameters(FUNCTIONS[name])


@pytest.mark.parametrize("name", [n for n, v in FUNCTIONS.items() if section(v, "Attributes")])
def test_the_attributes_described_are_there(name):
    value = FUNCTIONS[name]
    there = {*dir(value), *parameters(value), *re.findall(r"self\.(\w+)", inspect.getsource(value))}
    assert set(section(value, "Attributes")) <= there


def called_by_students() -> list[str]:
    """Functions of the students' rooms, and what notebooks import, with arguments to explain."""
    rooms = tuple(f"robocon_course.{room}" for room in ROOMS)
    handed = [getattr(home, n) for home in (view, exercises) for n in home.__all__]
    return [
        name
        for name, value in FUNCTIONS.items()
        if (name.startswith(rooms) or any(value is one for one in handed))
        and "." not in getattr(value, "__qualname__", "")  # no method
        and not inspect.isclass(value)
        and len(parameters(value)) > 1
    ]


@pytest.mark.parametrize("name", called_by_students())
def test_what_students_call_describes_every_argument(name):
    assert section(FUNCTIONS[name], "Parameters"), f"{name} does not describe its arguments"


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings_run(name):
    result = doctest.testmod(importlib.import_module(name), verbose=False)
    assert result.failed == 0


def test_there_are_examples_to_run():
    finder = doctest.DocTestFinder()
    tests = [t for name in MODULES for t in finder.find(importlib.import_module(name))]
    assert sum(len(test.examples) for test in tests) >= 3

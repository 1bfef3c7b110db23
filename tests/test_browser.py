"""In a real browser: open a chapter, run it, move a slider, solve, drive, operate a robot.

Screenshots of the steps lie in test-artefacts/ afterwards, to be looked at.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from conftest import ROOT, missing
from robocon_course.exercises import registry

pytestmark = pytest.mark.browser

ARTEFACTS = ROOT / "test-artefacts"
FLAGS = (
    "--no-sandbox",  # a build server's user is root; only our own pages are opened
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-quic",
    "--disable-sync",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
)
PATIENCE = 120  # s: a cold disk, a cold compiler cache, two busy cores
HOST = "127.0.0.1"

# Before a kernel has answered, a command to run cells is lost without a word.
READY = """async () => {
    const widget = jupyterapp.shell.currentWidget;
    await widget.revealed;
    await widget.sessionContext.ready;
    await widget.sessionContext.session.kernel.info;
}"""
ALL_RUN = """() => {
    const widget = jupyterapp.shell.currentWidget;
    return widget.sessionContext.session.kernel.status === 'idle' &&
        [...widget.content.model.cells].every(c => c.type !== 'code' || c.executionCount);
}"""
FIGURE = ".jp-OutputArea-output img"
BY_HAND = (
    "w, x, y, z = quaternion",
    "up = [2 * (x * z - w * y), 2 * (w * x + y * z), w * w - x * x - y * y + z * z]",
    "return np.array(up)",
)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory) -> Path:
    """A folder that does not exist yet; `robocon lab` makes it."""
    return tmp_path_factory.mktemp("course") / "robocon"


@pytest.fixture(scope="module")
def address(workspace, tmp_path_factory) -> Iterator[str]:
    """Address of a JupyterLab started as a student starts it, with nobody's settings."""
    home = tmp_path_factory.mktemp("home")
    settings = {
        "ServerApp": {"allow_root": True, "ip": HOST},  # root may start a server only if told so
        "LabApp": {"expose_app_in_browser": True},  # lets the test ask the page what is going on
    }
    (home / "jupyter_server_config.json").write_text(json.dumps(settings))
    folders = ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")
    log = home / "server.log"
    with log.open("w") as out:
        server = subprocess.Popen(
            [sys.executable, "-m", "robocon_course.cli", "lab", str(workspace), "--no-browser"],
            env=os.environ | dict.fromkeys(folders, str(home)),
            stdout=out,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        yield address_in(log, server)
    finally:
        end(server, log)


def address_in(log: Path, server: subprocess.Popen) -> str:
    """The address that a person would click on, once the server prints it."""
    for _ in range(10 * PATIENCE):
        found = re.search(rf"http://{HOST}:\d+/lab\S*token=\w+", log.read_text())
        if found:
            return found.group()
        if server.poll() is not None:
            break
        time.sleep(0.1)
    return pytest.fail(f"robocon lab names no address:\n{log.read_text()}")


def end(server: subprocess.Popen, log: Path) -> None:
    """Ask the server to end itself and its kernels, and end it where it does not."""
    for url in re.findall(rf"http://{HOST}:\d+/lab\S*token=\w+", log.read_text())[:1]:
        ask = urllib.request.Request(f"http://{urlsplit(url).netloc}/api/shutdown", method="POST")
        ask.add_header("Authorization", f"token {url.partition('token=')[2]}")
        with contextlib.suppress(OSError):
            urllib.request.urlopen(ask, timeout=20).close()
    try:
        server.wait(timeout=30)
    except subprocess.TimeoutExpired:
        os.killpg(server.pid, signal.SIGKILL)


@pytest.fixture(scope="module")
def hosts() -> set[str | None]:
    """Every host that the browser asked for something."""
    return set()


@pytest.fixture(scope="module")
def page(tmp_path_factory, hosts):
    """A page of a browser that was never used before."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        missing("no chromium on this machine; on Debian: apt-get install chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        missing('playwright is not installed; pip install -e ".[test]"')
    with sync_playwright() as play:
        context = play.chromium.launch_persistent_context(
            str(tmp_path_factory.mktemp("profile")),
            executable_path=program,
            headless=True,
            args=list(FLAGS),
            viewport={"width": 1280, "height": 900},
        )
        context.set_default_timeout(1000 * PATIENCE)
        context.on("request", lambda request: hosts.add(urlsplit(request.url).hostname))
        yield context.pages[0]
        context.close()


@pytest.fixture(scope="module")
def chapter(page, address):
    """Chapter 01, opened and run from top to bottom."""
    return run_through(page, address, "01_imu", "1-opened")


def run_through(page, address: str, name: str, picture: str):
    """The page with a notebook opened, photographed, and run from top to bottom."""
    ARTEFACTS.mkdir(exist_ok=True)
    parts = urlsplit(address)
    page.goto(f"http://{parts.netloc}/lab/tree/{name}.ipynb?{parts.query}")
    page.wait_for_selector(".jp-Notebook .jp-Cell")
    page.wait_for_function("window.jupyterapp?.shell.currentWidget?.sessionContext")
    page.evaluate(READY)
    photograph(page, picture)
    page.evaluate("() => { jupyterapp.commands.execute('notebook:run-all-cells') }")
    page.wait_for_function(ALL_RUN)
    return page


def photograph(page, name: str) -> None:
    page.screenshot(path=ARTEFACTS / f"{name}.png")


def cell_with(page, text: str):
    """The code cell with a text in its input, scrolled into view."""
    editor = page.locator(".jp-InputArea-editor", has_text=text)
    cell = page.locator(".jp-CodeCell", has=editor).first
    cell.scroll_into_view_if_needed()
    cell.locator(".jp-InputArea-prompt").click()  # the notebook shows the cell that is active
    return cell


def verdict(cell) -> str:
    return cell.locator("[role=status]").first.text_content()


def test_robocon_lab_opens_the_first_lesson_of_a_new_workspace(address, workspace):
    assert urlsplit(address).path == "/lab/tree/00_start.ipynb"
    assert {"00_start.ipynb", "01_imu.ipynb"} <= {path.name for path in workspace.iterdir()}


def test_an_untouched_chapter_runs_through_and_says_not_attempted(chapter):
    shown = chapter.locator(".jp-CodeCell [role=status]").all_text_contents()
    asked = [f"– not attempted: {exercise.id}, " for exercise in registry.chapter("imu").exercises]
    for line in asked:
        assert any(text.startswith(line) for text in shown), line
    assert not any(text.startswith(("✔", "✘", "!")) for text in shown)
    assert chapter.locator("[data-mime-type='application/vnd.jupyter.error']").count() == 0
    check = cell_with(chapter, 'check("imu.calibrate_gyro")')
    check.locator("[role=status]").scroll_into_view_if_needed()
    photograph(chapter, "2-not-attempted")


def test_every_figure_tells_its_content_to_a_screen_reader(chapter):
    figures = chapter.locator(FIGURE)
    assert figures.count() >= 8
    for text in figures.evaluate_all("all => all.map(one => one.alt)"):
        assert len(text) >= 20 and any(sign.isdigit() or sign == ";" for sign in text), text


def test_moving_a_slider_draws_the_same_figure_anew(chapter):
    move_first_slider(chapter, "explore(", 0.75, "3-slider-moved")


def move_first_slider(page, text: str, share: float, picture: str) -> str:
    """Pull the first slider of a cell up; the figure must follow, and its words; those words."""
    cell = cell_with(page, text)
    figure, number = cell.locator(FIGURE), cell.locator(".widget-readout").first
    before, start = figure.get_attribute("src"), float(number.text_content())
    handle = cell.locator(".noUi-handle").first
    handle.scroll_into_view_if_needed()
    grip, bar = handle.bounding_box(), cell.locator(".noUi-base").first.bounding_box()
    page.mouse.move(grip["x"] + grip["width"] / 2, grip["y"] + grip["height"] / 2)
    page.mouse.down()
    page.mouse.move(bar["x"] + share * bar["width"], grip["y"], steps=12)
    page.mouse.up()
    # JupyterLab puts a new image in the place of the old one; the text twin follows it.
    readout = cell.get_by_text("Figure: ")
    for _ in range(300):
        new = figure.get_attribute("src") != before
        if new and readout.text_content() == f"Figure: {figure.get_attribute('alt')}":
            break
        page.wait_for_timeout(100)
    figure.scroll_into_view_if_needed()
    photograph(page, picture)
    assert float(number.text_content()) > start
    assert figure.count() == 1 and figure.get_attribute("src") != before
    words = readout.text_content().removeprefix("Figure: ")
    assert words == figure.get_attribute("alt")
    return words


def test_an_exercise_is_solved_by_typing(chapter, workspace):
    cell = cell_with(chapter, "def gravity_direction(quaternion)")
    cell.get_by_text('raise NotImplementedError("not solved yet")').click()
    for key in ("End", "Shift+ArrowUp", "Shift+Home"):  # the two lines of the stub
        chapter.keyboard.press(key)
    for number, line in enumerate(BY_HAND):
        if number:
            chapter.keyboard.press("Enter")  # the editor indents the new line
        chapter.keyboard.type(line)
    photograph(chapter, "4-typed")
    chapter.keyboard.press("Shift+Enter")
    chapter.keyboard.press("Shift+Enter")
    check = cell_with(chapter, 'check("imu.gravity_direction")')
    check.get_by_text("✔ passed: imu.gravity_direction, 1 of 1 points").wait_for()
    photograph(chapter, "5-passed")
    assert "my_robot/imu.py" in verdict(check)
    assert BY_HAND[1] in (workspace / "my_robot" / "imu.py").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "slider", "words"),
    [
        ("04_planning", "explore(draw_weight", r"^Weight [345][.\d]*: \d+ cells, a way of"),
        ("05_tracking", "draw_lookahead,", r"^Look-ahead 0\.[678]\d* s times speed"),
    ],
)
def test_a_chapter_of_the_way_runs_untouched_and_its_slider_draws_it_anew(
    page, address, name, slider, words
):
    chapter = run_through(page.context.new_page(), address, name, f"{name}-opened")
    assert chapter.locator("[data-mime-type='application/vnd.jupyter.error']").count() == 0
    assert re.search(words, move_first_slider(chapter, slider, 0.75, f"{name}-slider"))


DRIVE = "from robocon_course.view import drive\ndrive()"


def run_own(page, address: str, workspace: Path, name: str, source: str) -> None:
    """A notebook of the student's own with one cell, opened and run."""
    kernel = {"display_name": "Python 3 (ipykernel)", "name": "python3"}
    cell = {"cell_type": "code", "id": "one", "metadata": {}, "outputs": []}
    cell |= {"execution_count": None, "source": source}
    notebook = {"cells": [cell], "metadata": {"kernelspec": kernel}}
    notebook |= {"nbformat": 4, "nbformat_minor": 5}
    (workspace / f"{name}.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    parts = urlsplit(address)
    page.goto(f"http://{parts.netloc}/lab/tree/{name}.ipynb?{parts.query}")
    page.wait_for_selector(".jp-Notebook .jp-Cell")
    page.wait_for_function("window.jupyterapp?.shell.currentWidget?.sessionContext")
    page.evaluate(READY)
    page.evaluate("() => { jupyterapp.commands.execute('notebook:run-all-cells') }")
    page.wait_for_function(ALL_RUN)


@pytest.fixture(scope="module")
def wheel(page, address, workspace):
    """A notebook of the student's own with the driving panel, its simulator started."""
    page = page.context.new_page()
    run_own(page, address, workspace, "drive", DRIVE)
    still = page.locator(FIGURE)
    still.wait_for()
    assert "heading 0°" in still.get_attribute("alt")
    page.locator("button.jupyter-button", has_text="Drive").click()
    page.get_by_text("x 0.55 m, y 0.35 m").wait_for()
    return page


def pull(page, slider: int, share: float) -> None:
    """Take the handle of a slider to a share of its bar."""
    grip = page.locator(".noUi-handle").nth(slider).bounding_box()
    bar = page.locator(".noUi-base").nth(slider).bounding_box()
    middle = grip["y"] + grip["height"] / 2
    page.mouse.move(grip["x"] + grip["width"] / 2, middle)
    page.mouse.down()
    page.mouse.move(bar["x"] + share * bar["width"], middle, steps=8)
    page.mouse.up()


def test_a_student_drives_the_robot_with_sliders_and_stops_it(wheel):
    picture = wheel.locator("img.widget-image")
    at_start, readout = (
        picture.get_attribute("src"),
        wheel.locator(".widget-html", has_text=" s: x"),
    )
    pull(wheel, 1, 0.75)  # vy: to the robot's left, towards ramp 1
    wheel.wait_for_function(
        "() => /y [1-9][.]/.test(document.querySelector('.jp-OutputArea').textContent)"
    )
    photograph(wheel, "6-driving")
    assert picture.get_attribute("src") != at_start
    wheel.locator("button.jupyter-button", has_text="Stop").click()
    rest = ""
    while rest != (rest := readout.text_content()):
        wheel.wait_for_timeout(500)
    photograph(wheel, "7-stopped")
    assert 1.0 < float(re.search(r"y ([\d.]+) m", rest)[1]) < 12.0
    assert wheel.locator(".widget-readout").all_text_contents() == ["0.00", "0.00", "0.00"]


OPERATED = """
import asyncio

import numpy as np

from robocon_course.robot import Bus, LidarReading, Observation, messages
from robocon_course.view.dashboard import dashboard

WAYS = [("wait", "drive", "start"), ("drive", "wait", "retry"), ("drive", "done", "arrived"),
        ("drive", "stuck", "coming nowhere"), ("stuck", "drive", "free again")]
bus = Bus()
screen = dashboard(bus, states=WAYS)
at = {"time": 0.0, "y": 0.35, "speed": 0.0}


def heard(topic, button):
    if button.name in ("start", "retry"):
        at["y"], at["speed"] = (0.35, 0.8) if button.name == "start" else (5.5, 0.0)
        state = "drive" if button.name == "start" else "wait"
        bus.publish("/mission/state", messages.State(at["time"], state, button.name))
        bus.publish("/rosout", messages.Log(at["time"], "warning", f"{button.name} <heard>"))


def seen():
    beams = [LidarReading(at["time"], d, 900, 30.0) for d in (2.4, 0.6, 0.5, 3.1)]
    zeros, turned = np.zeros((1, 3)), np.full(4, np.pi / 2)
    ticks = np.array([0, 0, int(17204 * at["y"])])
    return Observation(at["time"], ticks, np.array([at["time"]]), zeros, zeros + [0, 0, 9.8],
                       tuple(beams), np.full(4, at["speed"]), turned, 23.4)


async def robot():
    box = np.array([[90.0, 80.0, 150.0, 140.0]])
    found = messages.Detection2DArray(0.0, "ball", box, np.array([0.9]), ("red",))
    bus.publish("/camera/image", messages.Image(0.0, np.full((240, 320, 3), 120, np.uint8)))
    bus.publish("/camera/detections", found)
    bus.publish("/silos", messages.Silos(0.0, ("RB", "R", "", "BBR", "")))
    bus.publish("/plan", messages.Path(0.0, np.array([(0.55, 0.35), (0.55, 6.4), (4.3, 6.4)])))
    bus.publish("/mission/state", messages.State(0.0, "wait", ""))
    while True:
        at["time"] += 0.01
        at["y"] = min(6.4, at["y"] + 0.01 * at["speed"])
        pose = np.array([0.55, at["y"], 0.0])
        bus.publish("/observation", seen())
        bus.publish("/odom", messages.PoseStamped(at["time"], pose))
        bus.publish("/score", messages.Score(at["time"], 30, 10, 180.0 - at["time"]))
        await asyncio.sleep(0.01)


bus.subscribe("/operator", heard)
task = asyncio.get_running_loop().create_task(robot())
"""


BEYOND = """y => {
    const placed = document.querySelector('.rc-robot').getAttribute('transform');
    return parseFloat(placed.split(' -')[1]) > y;
}"""


def test_an_operator_starts_a_robot_sees_it_move_and_sends_it_to_retry(page, address, workspace):
    page = page.context.new_page()
    page.set_viewport_size({"width": 1280, "height": 800})
    run_own(page, address, workspace, "operate", OPERATED)
    for command in ("application:toggle-left-area", "notebook:hide-cell-code"):
        page.evaluate("one => { jupyterapp.commands.execute(one) }", command)
    page.get_by_text("● connected").wait_for()
    page.locator(".rc-bar").scroll_into_view_if_needed()
    robot = page.locator(".rc-robot")
    assert robot.get_attribute("transform") == "translate(55.0 -35.0) rotate(0.0)"
    photograph(page, "8-waiting")
    page.locator("button.jupyter-button", has_text="Start").click()
    page.wait_for_function(BEYOND, arg=100)
    assert page.locator(".rc-live").text_content().startswith("drive")
    photograph(page, "9-operated")
    page.locator("button.jupyter-button", has_text="Retry").click()
    page.get_by_text("retry <heard>").wait_for()
    page.wait_for_function(BEYOND, arg=549)
    assert page.locator("button.jupyter-button", has_text="Start").is_disabled(), (
        "a match that is retried runs on"
    )
    photograph(page, "10-retried")
    page.set_viewport_size({"width": 760, "height": 1200})
    page.wait_for_timeout(500)
    photograph(page, "11-half-width")


PLAYED = """
from robocon_course.view.playing import operate
from robocon_course.worlds import Play

operate(lambda bus: Play(seed=7, bus=bus), speed=2.0)
"""


def test_a_match_is_started_watched_and_sent_to_retry_from_the_operators_screen(
    page, address, workspace
):
    page = page.context.new_page()
    page.set_viewport_size({"width": 1280, "height": 800})
    run_own(page, address, workspace, "play", PLAYED)
    for command in ("application:toggle-left-area", "notebook:hide-cell-code"):
        page.evaluate("one => { jupyterapp.commands.execute(one) }", command)
    before = page.locator("img[alt*='is not open yet']")
    assert before.count() == 1 and page.locator(".rc-bar").count() == 0
    page.locator("button.jupyter-button", has_text="Open the operator's screen").click()
    page.get_by_text("● connected").wait_for(timeout=120_000)
    assert before.count() == 0, "the screen takes the picture's place"
    page.locator(".rc-bar").scroll_into_view_if_needed()
    page.locator("button.jupyter-button", has_text="Start").click()
    page.wait_for_function(BEYOND, arg=250)
    assert page.locator(".rc-live").text_content().startswith("go_to_area_3")
    photograph(page, "12-match")
    page.locator("button.jupyter-button", has_text="Retry").click()
    page.get_by_text("own: retry").wait_for()
    photograph(page, "13-match-retried")


def test_nothing_is_fetched_from_the_internet(chapter, hosts):
    assert hosts - {None} == {HOST}

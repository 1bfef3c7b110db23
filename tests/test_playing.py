"""A match behind the operator's screen in a notebook: offered, opened, and what goes wrong."""

from __future__ import annotations

import asyncio

import pytest
from IPython.core.interactiveshell import InteractiveShell

from robocon_course.robot import Bus
from robocon_course.view import playing
from robocon_course.worlds import Play


@pytest.fixture
def notebook(monkeypatch):
    """Everything that a notebook would have received: data, display id, update."""
    shell, sent = InteractiveShell.instance(), []

    def publish(data, metadata=None, *, transient=None, update=False, **_):
        sent.append((data, (transient or {}).get("display_id"), update))

    monkeypatch.setattr(shell.display_pub, "publish", publish)
    monkeypatch.setattr(shell, "kernel", object(), raising=False)
    yield sent
    InteractiveShell.clear_instance()


def test_a_cell_that_offers_a_match_makes_none(notebook):
    playing.operate(lambda bus: pytest.fail("nobody pressed the button"))
    (picture, place, _), (button, _, _) = notebook
    assert "The robot at its start at (0.55, 0.35) m" in picture["text/plain"] and place
    assert button["text/plain"] == "Button: Open the operator's screen"


def test_outside_a_notebook_the_start_is_shown_and_a_sentence_says_why(capsys):
    playing.operate(lambda bus: pytest.fail("there is no button to press"))
    figure, sentence = capsys.readouterr().out.splitlines()
    assert figure.startswith("Figure: The robot at its start")
    assert sentence == "The operator's screen needs a notebook with ipywidgets."


def test_the_button_puts_the_screen_of_a_match_in_the_place_of_the_picture(notebook):
    async def press():
        offer = playing.Offer(lambda bus: Play(seed=1, opponent=None, bus=bus), 1.0, "here")
        offer.button.click()
        assert offer.button.disabled and offer.words.value == "Starting the simulator …"
        await offer.task
        before = offer.screen.inbox.now()
        await asyncio.sleep(0.3)
        assert offer.widget.layout.display == "none"
        assert offer.screen.inbox.now() > before, "the robot's clock runs"
        offer.screen.close()
        return await offer.screen.task

    asyncio.run(press())
    data, place, update = notebook[-1]
    assert data["text/plain"].startswith("Dashboard: ") and place == "here" and update


def test_what_goes_wrong_is_said_at_the_button_and_it_may_be_pressed_again(notebook):
    async def press():
        offer = playing.Offer(lambda bus: Play(team="<green>", bus=bus), 1.0, "here")
        offer.button.click()
        await offer.task
        return offer

    offer = asyncio.run(press())
    assert "expected one of red, blue, got &#x27;&lt;green&gt;&#x27;" in offer.words.value
    assert not offer.button.disabled and offer.screen is None


def test_a_match_without_a_bus_is_refused(notebook):
    with pytest.raises(ValueError, match="expected one with a bus"):
        playing.play_live(Play(seed=1, opponent=None))


def test_after_the_end_the_robot_stands_and_is_heard_until_the_next_start(notebook, monkeypatch):
    monkeypatch.setattr("robocon_course.simulator.match.MATCH", 1.0)
    play = Play(seed=1, opponent=None, bus=Bus())

    async def watch():
        screen = playing.play_live(play, speed=20.0)
        screen.controls.start.click()
        first = play.match
        while not first.over:
            await asyncio.sleep(0.05)
        await asyncio.sleep(2.0)  # longer than a robot may be silent
        assert screen.inbox.connected() and not screen.inbox.running
        assert first.robot.motion[1] == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
        assert not screen.controls.start.disabled
        assert play.bus.latest["/operator"].name == "stop", "whoever writes it down was told"
        screen.controls.start.click()
        assert play.match is not first and not play.pilot.stopped
        screen.close()
        await screen.task

    asyncio.run(watch())

"""Who tells, and who listens: a publish/subscribe bus inside one process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Listener = Callable[[str, Any], object]


class Bus:
    """Passes messages on, by topic, in the order in which they are told.

    What a listener itself tells, while it is told something, is passed on at once: those who were
    not asked yet hear it before what caused it.

    A listener that raises is not asked again, and nobody else notices: a screen never stops a
    robot. What it raised is kept in `failed`.

    Attributes
    ----------
    latest : dict
        The last message of each topic.
    failed : list of (str, Exception)
        Topic and error of each listener that was dropped.

    Examples
    --------
    >>> bus, heard = Bus(), []
    >>> stop = bus.subscribe("/rosout", lambda topic, message: heard.append(message))
    >>> bus.publish("/rosout", "ready")
    >>> stop()
    >>> bus.publish("/rosout", "gone")
    >>> heard, bus.latest["/rosout"]
    (['ready'], 'gone')
    """

    def __init__(self) -> None:
        self.latest: dict[str, Any] = {}
        self.failed: list[tuple[str, Exception]] = []
        self._listeners: dict[str, dict[object, Listener]] = {}

    def subscribe(self, topic: str, listener: Listener) -> Callable[[], None]:
        """Be told everything on a topic.

        Parameters
        ----------
        topic : str
            A name such as ``"/odom"``; ``"*"`` is every topic.
        listener : callable
            Called with topic and message.

        Returns
        -------
        callable
            Ends this subscription; again, nothing more happens.

        Raises
        ------
        ValueError
            A listener that cannot be called.
        """
        if not callable(listener):
            raise ValueError(f"listener: expected a function, got {type(listener).__name__}")
        listeners, key = self._listeners.setdefault(topic, {}), object()
        listeners[key] = listener

        def stop() -> None:
            listeners.pop(key, None)

        return stop

    def publish(self, topic: str, message: Any) -> None:
        """Tell everybody who listens to a topic, now.

        Parameters
        ----------
        topic : str
        message : one of `messages`
        """
        self.latest[topic] = message
        for heard in (topic, "*"):
            for key, listener in list(self._listeners.get(heard, {}).items()):
                try:
                    listener(topic, message)
                except Exception as error:  # whatever a screen does, the robot drives on
                    self.failed.append((topic, error))
                    self._listeners[heard].pop(key, None)  # it may have stopped by itself

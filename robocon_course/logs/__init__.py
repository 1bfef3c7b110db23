"""Match logs: what was told on the bus, in a file that Foxglove and Lichtblick open.

============  ==================================================================
``writer``    `MatchLog` listens to a bus and writes an MCAP file
``reader``    `read_log` gives the messages back, `summary` what is in a file
``replay``    `Replay`, a robot that sees it all once more
``kinds``     every kind of message: how it is written and read
``drawn``     the kinds that Foxglove has a word for
``foxglove``  Foxglove's schemas
``schemas``   the course's own
============  ==================================================================

A log needs the library ``mcap``: ``pip install "robocon-course[logs]"``.
"""

from robocon_course.logs.reader import LogFile, Summary, read_log, summary
from robocon_course.logs.replay import Replay
from robocon_course.logs.writer import LogError, MatchLog

__all__ = ["LogError", "LogFile", "MatchLog", "Replay", "Summary", "read_log", "summary"]

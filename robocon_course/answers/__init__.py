"""A student's code runs here, in a process of its own, and never where it is judged.

``process.AnswerProcess`` is the near side: it starts the process, sends inputs, waits no longer
than allowed, and ends it. ``worker`` is the far side: it holds the student's functions and
nothing of the checks. ``wire`` is what passes between them: plain data only.
"""

"""Build the autonomy of a competition robot, chapter by chapter.

The rooms, from the ground floor up; imports run downwards only:

==================  =========================================================
``geometry``        quaternions and angles
``files``           where the course's data and lessons lie
``imu``             chapter 01: calibration, Mahony filter, a phone as sensor
``field``           the game field of 2024 in numbers
``simulator``       sensors and motions that need no hardware
``worlds``          student number -> seed -> a sensor world of one's own
``autopilot``       the robot's replaceable parts and the order they run in
``view``            figures and sliders: draw what they are given
``recordings``      files of a recording in, files of results out
``answers``         a student's code runs here, in a process of its own
``exercises``       check, hint, answer, and each chapter's exercises
``grading``         other people's notebooks, judged in processes of their own
``lessons``         solutions/NN_topic.py -> notebooks
``desk``            a student's folder: make it, find it, begin a lesson anew
``doctor``          is this computer ready, and what mends it
``cli``             the command ``robocon``
==================  =========================================================

Importing this package loads none of them.
"""

__version__ = "0.1.0"

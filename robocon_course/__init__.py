"""Build the autonomy of a competition robot, chapter by chapter.

The rooms, from the ground floor up; imports run downwards only:

==================  =========================================================
``geometry``        quaternions and angles
``files``           where the course's data and lessons lie
``imu``             chapter 01: calibration, Mahony filter, a phone as sensor
``field``           the game field of 2024 in numbers
``simulator``       sensors and motions that need no hardware
``autopilot``       the robot's replaceable parts and the order they run in
``view``            figures and sliders: draw what they are given
``exercises``       check, hint, answer, and each chapter's exercises
``grading``         other people's notebooks, judged in processes of their own
``lessons``         solutions/NN_topic.py -> notebooks
``cli``             the command ``robocon``
==================  =========================================================

Importing this package loads none of them.
"""

__version__ = "0.1.0"

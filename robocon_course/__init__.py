"""Build the autonomy of a competition robot, chapter by chapter.

The rooms, from the ground floor up; imports run downwards only:

==================  ==========================================================
``files``           where the course's data and lessons lie
``geometry``        angles, poses in the plane, quaternions
``gridmap``         a bitmap with a place: metres <-> cells, ROS maps in and out
``drivetrain``      one linear map, body twist -> wheel speeds, for every drive
``raycast``         how far a beam goes through a grid
``field``           the game field of 2024: numbers, obstacle bitmap, heights
``imu``             chapter 01: calibration, Mahony filter, a phone as sensor
``odometry``        chapter 02: dead wheels -> pose
``swerve``          chapter 03: body twist -> four modules, and back
``planning``        chapter 04: obstacle map -> shortest way, and a new one on the way
``tracking``        chapter 05: path -> curvature, speed, velocity; PID
``vision``          chapter 06: pictures drawn, networks trained and run, boxes -> places
``robot``           what autonomy and hardware agree on: Observation, Command
``simulator``       a robot on its field that needs no hardware
``worlds``          student number -> seed -> a robot of one's own
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
==================  ==========================================================

Importing this package loads none of them.
"""

__version__ = "0.1.0"

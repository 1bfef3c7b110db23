"""A robot that needs no hardware: what it does with commands, and what its sensors say.

============  ==================================================================
``machine``   `Simulator`: read, apply, step; the truth apart
``truth``     `Truth`: what is really so
``model``     `RobotModel`: the true sizes of one robot, and the field under it
``physics``   wheels that grip and slide, ramps, walls
``sensors``   `SensorModel`: all sensors' errors and rates
``inertial``  what the IMU reads
``lidar``     what the LiDARs read
``encoders``  what the encoders of dead wheels and modules read
``camera``    what the robot's camera sees; imported by name, because it draws
``noise``     random numbers by row
``numbers``   refusals of what is no number of a model
``motions``   known motions for an IMU to record
``match``     `Match`: a whole match around that robot; imported by name, as the next ones
``balls``     balls that roll and are pushed
``glimpse``   what a detector would say, without a picture
``referee``   rules, points, and the other team's plan
``others``    who else plays
``faults``    what goes wrong
``warm``      `warm_up`: compile before a robot is needed
============  ==================================================================
"""

from robocon_course.simulator.machine import Simulator
from robocon_course.simulator.model import RobotModel
from robocon_course.simulator.sensors import IDEAL, LidarErrors, SensorModel
from robocon_course.simulator.truth import Truth
from robocon_course.simulator.warm import warm_up

__all__ = ["IDEAL", "LidarErrors", "RobotModel", "SensorModel", "Simulator", "Truth", "warm_up"]

"""A robot that needs no hardware.

===========  ==================================================
``sensors``  what an IMU reads of a motion that is known exactly
===========  ==================================================
"""

"""Chapter 03: how do four steered wheels make one motion, and what motion did they make?

    twist → (field-centric) → discretize → module_targets → limit_speeds → shortest_turn → modules
    modules → body_twist → twist, and how badly the wheels disagree

Each step is a function of its own; each can be left out, and each can be the student's.

=============  ====================================================================
``modules``    `SwerveDrive`, twist -> speed and angle of each module, and what makes the
               command kinder: shorter turns, limits, compensation
``motion``     modules -> twist with residual; field-centric command, discretisation,
               and the control law that leads to a still or moving target
``following``  that law at work: a robot without mass behind a still or moving target
``slip``       which wheel slips: the one without which the others agree
=============  ====================================================================
"""

from robocon_course.swerve.following import Following, Target, circle, figure_eight, follow
from robocon_course.swerve.modules import (
    REST,
    ModuleTargets,
    SwerveDrive,
    cosine_compensation,
    limit_speeds,
    module_targets,
    shortest_turn,
)
from robocon_course.swerve.motion import (
    BodyMotion,
    body_motion,
    body_twist,
    discretize,
    field_to_robot,
    pose_feedback,
)
from robocon_course.swerve.slip import NO_SLIP, find_slip

__all__ = [
    "NO_SLIP",
    "REST",
    "BodyMotion",
    "Following",
    "ModuleTargets",
    "SwerveDrive",
    "Target",
    "body_motion",
    "body_twist",
    "circle",
    "cosine_compensation",
    "discretize",
    "field_to_robot",
    "figure_eight",
    "find_slip",
    "follow",
    "limit_speeds",
    "module_targets",
    "pose_feedback",
    "shortest_turn",
]

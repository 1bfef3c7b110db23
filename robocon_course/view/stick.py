"""What a stick asks for: the ends of its way, its dead zone, the axes of a gamepad."""

from __future__ import annotations

from collections.abc import Sequence

LIMITS = (2.0, 2.0, 3.0)
"""Ends of a stick's way: vx, vy [m/s] and omega [rad/s]."""
NAMES = ("vx [m/s]", "vy [m/s]", "ω [rad/s]")
DEAD_ZONE = 0.15
"""A stick that is let go stands within this share of its way."""
AXES = (1, 0, 2)
"""Axes of a gamepad for vx, vy and omega: the left stick drives, the right one turns."""


def pushed(axes: Sequence[float]) -> tuple[float, float, float]:
    """The twist that the sticks of a gamepad ask for.

    Parameters
    ----------
    axes : sequence of float, -1 to 1
        As a browser counts them: to the right and down. A missing axis stands at rest.

    Returns
    -------
    tuple (vx, vy, omega)  [m/s, m/s, rad/s; base]

    Examples
    --------
    >>> pushed([-0.5, 0.1, 1.0])
    (0.0, 1.0, -3.0)
    """
    pushes = [-axes[k] if k < len(axes) else 0.0 for k in AXES]
    vx, vy, omega = (
        0.0 if abs(push) < DEAD_ZONE else push * end
        for push, end in zip(pushes, LIMITS, strict=True)
    )
    return vx, vy, omega

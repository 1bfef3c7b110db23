"""How does the robot move when its four modules are asked to?

The robot is a flat body with place, heading and velocity in the map's plane, on wheels that grip
as well as friction lets them. With u_i the floor's velocity that wheel i would roll with, v_i the
body's velocity above it, and N = m g / 4 the load on a wheel:

    F_i = μ N (u_i - v_i) / max(|u_i - v_i|, ε)        grip, and a slide beyond it
    m v' = Σ F_i - m g ∇h                              h: the floor's height
    J ω' = Σ r_i × F_i

ε = 1 mm/s makes Coulomb's law a number everywhere. It also makes it stiff, so each step asks for
the forces that hold at its end: with K_i = μ N / max(slip, ε) the law is linear in the velocity,
three equations; solving and taking the slip anew a few times finds the K_i (reweighted least
squares). Walls push the body out and take the velocity that goes into them. Left out: the load
that braking or modules out of the middle shift from wheel to wheel.

All kernels trust their input. They stand in one file: numba looks only here for changes.

Source: P. Holland, R. Welsch, Robust regression using iteratively reweighted least-squares,
Communications in Statistics A6, 1977 (the iteration); D. Baraff, Physically Based Modeling,
SIGGRAPH course notes, 2001, part II, equation 8-18 (impulse of a collision).
"""

from __future__ import annotations

from math import cos, floor, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from robocon_course._arrays import FloatArray
from robocon_course.geometry import GRAVITY

TICK = 0.002
"""Longest step of the physics, and the grid on which sensors sample [s]."""
CREEP = 1e-3
"""Slip at which a wheel grips with all it has [m/s]."""
SOLVES = 4
"""How often the slip is taken anew in a step."""
TOUCH = 1e-3
"""A gap narrower than this counts as contact [m]."""
PUSHES = 3
"""How often a step looks for walls again after pushing the body out of one."""
REST = 1e-9
"""Slower than this is standing still [m/s, rad/s]."""
SMOOTHING = 0.02
"""The battery's voltage follows the load with this time constant [s]."""


inlined = njit(inline="always")
"""For the parts of `advance`: a call would count anew who holds each of a state's arrays."""


class Body(NamedTuple):
    """One robot's numbers, as the kernels take them: see `RobotModel`.

    ``plane`` (3, 4) makes the rise along x and y, and the height of the middle, of the heights
    under the four modules.
    """

    half: float
    mass: float
    inertia: float
    friction: float
    wall_friction: float
    steering_lag: float
    steering_rate: float
    drive_lag: float
    drive_acceleration: float
    drive_force: float
    max_speed: float
    battery: float
    resistance: float
    modules: FloatArray
    plane: FloatArray
    dead_wheels: FloatArray


class State(NamedTuple):
    """All that moves; the kernels change the arrays in place.

    Attributes
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
    velocity : ndarray, shape (4,)  [m/s, m/s, rad/s, m/s; map]
        The last one is upwards.
    floor : ndarray, shape (3,)
        Rise of the robot's plane along its x and y axis [m per m], and height of its middle [m].
    angles, speeds : ndarray, shape (4,)  [rad, m/s]
        Of the modules.
    travel : ndarray, shape (n,)  [m]
        What each dead wheel rolled.
    wheels : ndarray, shape (4, 10)
        Of each module, x and y in map axes: where it stands from the robot's middle [m], how it
        would roll [m/s], its force on the body [N], the floor's rise under it [m per m], and the
        direction in which it rolls.
    battery : ndarray, shape (1,)  [V]
    contact : ndarray of int64, shape (2,)
        Whether the body touches something, and how often it began to.
    """

    pose: FloatArray
    velocity: FloatArray
    floor: FloatArray
    angles: FloatArray
    speeds: FloatArray
    travel: FloatArray
    wheels: FloatArray
    battery: FloatArray
    contact: np.ndarray

    @classmethod
    def at_rest(cls, pose: FloatArray, body: Body) -> State:
        """All that moves, at a pose (3,) [m, m, rad; map], standing still and not yet set down."""
        return cls(
            pose=pose.copy(),
            velocity=np.zeros(4),
            floor=np.zeros(3),
            angles=np.zeros(4),
            speeds=np.zeros(4),
            travel=np.zeros(len(body.dead_wheels)),
            wheels=np.zeros((4, 10)),
            battery=np.array([body.battery]),
            contact=np.zeros(2, np.int64),
        )


class World(NamedTuple):
    """What the robot stands on and runs into.

    Attributes
    ----------
    floor : ndarray, shape (k, 7)
        As `field.FLOOR_TABLE`.
    boxes : ndarray, shape (m, 4)  [m, map]
        x0, y0, x1, y1 of what the body cannot enter.
    """

    floor: FloatArray
    boxes: FloatArray


TRACK = 9
"""Columns of a track: x, y, theta, velocity along x, y and up, rise along the robot's x and y axis,
height."""


@njit(cache=True)
def advance(state, command, body, world, h, tick, ticks, track):
    """Move ``ticks`` times by ``h`` seconds; each step's result goes into ``track``.

    Parameters
    ----------
    state : State
    command : ndarray, shape (2, 4)  [m/s, rad]
        Speeds and angles of the modules.
    body : Body
    world : World
    h : float  [s]
        At most `TICK`.
    tick : int
        Number of the first step's end; row ``tick % len(track)`` takes it.
    ticks : int
        0 only sets the robot on the floor, and out of what it stands in.
    track : ndarray, shape (rows, TRACK)
        The newest rows, in turn.
    """
    for k in range(max(ticks, 1)):
        before = (state.pose[0], state.pose[1], state.pose[2])
        height = state.floor[2]
        if ticks > 0:
            _drive_modules(state, command, body, h)
            vx, vy, omega = state.velocity[0], state.velocity[1], state.velocity[2]
            _grip(state, body, h)
            state.pose[0] += 0.5 * h * (vx + state.velocity[0])
            state.pose[1] += 0.5 * h * (vy + state.velocity[1])
            state.pose[2] += 0.5 * h * (omega + state.velocity[2])
        _collide(state, body, world.boxes)
        _roll(state, body, world.floor, before)
        _stand(state, body, world.floor)
        if ticks > 0:
            state.velocity[3] = (state.floor[2] - height) / h
        _note(state, track[(tick + k) % len(track)])


@inlined
def _note(state, row):
    """One row of the track."""
    row[0], row[1], row[2] = state.pose[0], state.pose[1], state.pose[2]
    row[3], row[4], row[5] = state.velocity[0], state.velocity[1], state.velocity[3]
    row[6], row[7], row[8] = state.floor[0], state.floor[1], state.floor[2]


@inlined
def _limited(value, most):
    """``value``, or ``most`` with its sign."""
    return min(max(value, -most), most)


@inlined
def _drive_modules(state, command, body, h):
    """Modules turn and wheels spin up: a lag, a fastest rate, and a voltage that allows so much."""
    top = body.max_speed * state.battery[0] / body.battery
    for i in range(4):
        error = command[1, i] - state.angles[i]
        error -= 2.0 * pi * floor(error / (2.0 * pi) + 0.5)  # the shorter way round
        rate = _limited(error / max(body.steering_lag, h), body.steering_rate)
        angle = state.angles[i] + h * rate
        state.angles[i] = angle - 2.0 * pi * floor(angle / (2.0 * pi) + 0.5)
        error = _limited(command[0, i], top) - state.speeds[i]
        rate = _limited(error / max(body.drive_lag, h), body.drive_acceleration)
        speed = state.speeds[i] + h * rate
        state.speeds[i] = speed if abs(speed) > REST else 0.0


@inlined
def _grip(state, body, h):
    """Velocity at the step's end, from the wheels' grip and the slope."""
    velocity, wheels = state.velocity, state.wheels
    heading = state.pose[2] + h * velocity[2]  # at the step's end
    c, s = cos(heading), sin(heading)
    rise_x = c * state.floor[0] - s * state.floor[1]  # from robot to map axes
    rise_y = s * state.floor[0] + c * state.floor[1]
    steep = 1.0 + rise_x * rise_x + rise_y * rise_y
    most = 0.25 * body.friction * body.mass * GRAVITY / sqrt(steep)  # mu N
    pull = h * GRAVITY / steep
    free = velocity[0] - pull * rise_x, velocity[1] - pull * rise_y, velocity[2]
    for i in range(4):
        mx, my = body.modules[i, 0], body.modules[i, 1]
        wheels[i, 0], wheels[i, 1] = c * mx - s * my, s * mx + c * my
        dx, dy = cos(heading + state.angles[i]), sin(heading + state.angles[i])
        along = wheels[i, 6] * dx + wheels[i, 7] * dy  # a wheel rolls along the slope
        speed = state.speeds[i] / sqrt(1.0 + along * along)
        wheels[i, 2], wheels[i, 3] = speed * dx, speed * dy
        wheels[i, 8], wheels[i, 9] = dx, dy
    there = _rolling_velocity(wheels, body, h * most, free, (velocity[0], velocity[1], velocity[2]))
    _push(state, body, h, most, there, free)


@inlined
def _rolling_velocity(wheels, body, limit, free, guess):
    """Velocity (x, y, turn) at the step's end: (M + h Σ K JᵀJ) v = M v_free + h Σ K Jᵀ u."""
    vx, vy, turn = guess
    slid = True
    for _ in range(SOLVES):
        a, d, p, q = body.mass, body.inertia, 0.0, 0.0
        bx, by, bt = body.mass * free[0], body.mass * free[1], body.inertia * free[2]
        slides = False
        for i in range(4):
            x, y, ux, uy = wheels[i, 0], wheels[i, 1], wheels[i, 2], wheels[i, 3]
            slip = sqrt((ux - vx + turn * y) ** 2 + (uy - vy - turn * x) ** 2)
            slides |= slip > CREEP
            hk = limit / max(slip, CREEP)
            a, d = a + hk, d + hk * (x * x + y * y)
            p, q = p - hk * y, q + hk * x
            bx, by, bt = bx + hk * ux, by + hk * uy, bt + hk * (x * uy - y * ux)
        if not (slides or slid):  # the K were these already
            break
        slid = slides
        turn = (bt - (p * bx + q * by) / a) / (d - (p * p + q * q) / a)
        vx, vy = (bx - p * turn) / a, (by - q * turn) / a
    return vx, vy, turn


@inlined
def _push(state, body, h, most, there, free):
    """Forces for the slip at the step's end, none above its limit; velocity and load from them."""
    wheels, velocity = state.wheels, state.velocity
    fx = fy = torque = power = 0.0
    for i in range(4):
        x, y, ux, uy = wheels[i, 0], wheels[i, 1], wheels[i, 2], wheels[i, 3]
        slip_x, slip_y = ux - there[0] + there[2] * y, uy - there[1] - there[2] * x
        share = most / max(sqrt(slip_x * slip_x + slip_y * slip_y), CREEP)
        px, py = share * slip_x, share * slip_y
        dx, dy = wheels[i, 8], wheels[i, 9]
        asked = px * dx + py * dy
        excess = asked - _limited(asked, body.drive_force)
        px, py = px - excess * dx, py - excess * dy
        wheels[i, 4], wheels[i, 5] = px, py
        fx, fy, torque = fx + px, fy + py, torque + x * py - y * px
        power += abs(px * ux + py * uy)
    velocity[0] = free[0] + h * fx / body.mass
    velocity[1] = free[1] + h * fy / body.mass
    velocity[2] = free[2] + h * torque / body.inertia
    for j in range(3):  # a robot at rest would creep through ever smaller numbers, which are slow
        velocity[j] = velocity[j] if abs(velocity[j]) > REST else 0.0
    _stall(state, body.drive_force)
    sag = max(body.battery - body.resistance * power / body.battery, 0.0)
    state.battery[0] += min(h / SMOOTHING, 1.0) * (sag - state.battery[0])


@inlined
def _stall(state, drive_force):
    """A motor that gives all it has cannot spin its wheel: the floor takes the wheel along."""
    wheels, turn = state.wheels, state.velocity[2]
    for i in range(4):
        x, y, px, py = wheels[i, 0], wheels[i, 1], wheels[i, 4], wheels[i, 5]
        dx, dy = wheels[i, 8], wheels[i, 9]
        given = px * dx + py * dy
        if abs(given) > drive_force * (1.0 - 1e-9):
            vx, vy = state.velocity[0] - turn * y, state.velocity[1] + turn * x
            along = wheels[i, 6] * dx + wheels[i, 7] * dy  # as in `_grip`, the other way
            rolled = (vx * dx + vy * dy) * sqrt(1.0 + along * along)
            state.speeds[i] = rolled + (CREEP if given > 0.0 else -CREEP)


@inlined
def _floor_at(x, y, table):
    """Height of the floor at a point, and its rise along x and y [map]."""
    for k in range(len(table) - 1, -1, -1):  # where rectangles overlap, the later one holds
        if table[k, 0] <= x <= table[k, 2] and table[k, 1] <= y <= table[k, 3]:
            rise_x, rise_y = table[k, 5], table[k, 6]
            height = table[k, 4] + rise_x * (x - table[k, 0]) + rise_y * (y - table[k, 1])
            return height, rise_x, rise_y
    return 0.0, 0.0, 0.0


@inlined
def _stand(state, body, floor):
    """Heights under the four wheels, and the plane that fits them best: tilt and height."""
    c, s = cos(state.pose[2]), sin(state.pose[2])
    plane, along_x, along_y, middle = body.plane, 0.0, 0.0, 0.0
    for i in range(4):
        mx, my = body.modules[i, 0], body.modules[i, 1]
        x, y = state.pose[0] + c * mx - s * my, state.pose[1] + s * mx + c * my
        height, rise_x, rise_y = _floor_at(x, y, floor)
        state.wheels[i, 6], state.wheels[i, 7] = rise_x, rise_y
        along_x, along_y = along_x + plane[0, i] * height, along_y + plane[1, i] * height
        middle += plane[2, i] * height
    state.floor[0], state.floor[1], state.floor[2] = along_x, along_y, middle


@inlined
def _roll(state, body, floor, before):
    """Dead wheels roll along the floor, as far as their own place went in their direction."""
    dx, dy = state.pose[0] - before[0], state.pose[1] - before[1]
    turn = state.pose[2] - before[2]
    heading = before[2] + 0.5 * turn
    c, s = cos(heading), sin(heading)
    for i in range(len(body.dead_wheels)):
        wx, wy = body.dead_wheels[i, 0], body.dead_wheels[i, 1]
        x, y = c * wx - s * wy, s * wx + c * wy
        direction = heading + body.dead_wheels[i, 2]
        cd, sd = cos(direction), sin(direction)
        _, rise_x, rise_y = _floor_at(before[0] + x, before[1] + y, floor)
        along = rise_x * cd + rise_y * sd
        way = cd * (dx - turn * y) + sd * (dy + turn * x)
        state.travel[i] += way * sqrt(1.0 + along * along)


# --- walls ---------------------------------------------------------------------------------------


@inlined
def _collide(state, body, boxes):
    """Push the body out of what it entered, and take the velocity that goes into it."""
    touching = False
    for _ in range(PUSHES):
        entered = False
        x, y, far = state.pose[0], state.pose[1], 1.5 * body.half  # no corner is farther out
        for k in range(len(boxes)):
            if not (boxes[k, 0] < x + far and x < boxes[k, 2] + far):
                continue
            if not (boxes[k, 1] < y + far and y < boxes[k, 3] + far):
                continue
            gap, nx, ny = _gap_to(state.pose, body.half, boxes[k])
            touching |= gap <= TOUCH
            if gap < 0.0:
                entered = True
                rx, ry = _meeting_point(state.pose, body.half, boxes[k], nx, ny)
                _bounce(state, body, rx, ry, nx, ny)
                state.pose[0] -= gap * nx
                state.pose[1] -= gap * ny
        if not entered:
            break
    state.contact[1] += touching and not state.contact[0]
    state.contact[0] = touching


@inlined
def _gap_to(pose, half, box):
    """Gap between body and box, negative inside, and the direction out of the box.

    Two rectangles are apart if they are along an axis of one of them; of the four, the axis with
    the widest gap is the way out (separating axes).
    """
    hx, hy = 0.5 * (box[2] - box[0]), 0.5 * (box[3] - box[1])
    x, y = pose[0] - 0.5 * (box[0] + box[2]), pose[1] - 0.5 * (box[1] + box[3])
    c, s = cos(pose[2]), sin(pose[2])
    reach = half * (abs(c) + abs(s))
    best, nx, ny = abs(x) - hx - reach, 1.0 if x > 0.0 else -1.0, 0.0
    gap = abs(y) - hy - reach
    if gap > best:
        best, nx, ny = gap, 0.0, 1.0 if y > 0.0 else -1.0
    for ax, ay in ((c, s), (-s, c)):
        way = x * ax + y * ay
        gap = abs(way) - half - hx * abs(ax) - hy * abs(ay)
        if gap > best + 1e-9:
            side = 1.0 if way > 0.0 else -1.0
            best, nx, ny = gap, side * ax, side * ay
    return best, nx, ny


@inlined
def _meeting_point(pose, half, box, nx, ny):
    """Where they meet, from the body's middle: corners inside the other, weighted by depth."""
    c, s = cos(pose[2]), sin(pose[2])
    middle_x, middle_y = 0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3])
    hx, hy = 0.5 * (box[2] - box[0]), 0.5 * (box[3] - box[1])
    top = hx * abs(nx) + hy * abs(ny)  # the box's face, along the way out
    bottom = -half * (abs(c * nx + s * ny) + abs(c * ny - s * nx))  # the body's
    weight = x_sum = y_sum = 0.0
    for i in (-1.0, 1.0):
        for j in (-1.0, 1.0):
            x = pose[0] + half * (c * i - s * j)
            y = pose[1] + half * (s * i + c * j)
            depth = top - (x - middle_x) * nx - (y - middle_y) * ny
            if depth > 0.0 and box[0] <= x <= box[2] and box[1] <= y <= box[3]:
                weight, x_sum, y_sum = weight + depth, x_sum + depth * x, y_sum + depth * y
            x, y = middle_x + i * hx, middle_y + j * hy
            dx, dy = x - pose[0], y - pose[1]
            depth = dx * nx + dy * ny - bottom
            if depth > 0.0 and abs(c * dx + s * dy) <= half and abs(c * dy - s * dx) <= half:
                weight, x_sum, y_sum = weight + depth, x_sum + depth * x, y_sum + depth * y
    if weight == 0.0:
        return bottom * nx, bottom * ny
    return x_sum / weight - pose[0], y_sum / weight - pose[1]


@inlined
def _bounce(state, body, x, y, nx, ny):
    """Impulse at (x, y) from the middle: no bounce, friction across; off-centre it spins."""
    v = state.velocity
    into = (v[0] - v[2] * y) * nx + (v[1] + v[2] * x) * ny
    if into >= 0.0:
        return
    lever = x * ny - y * nx
    hit = -into / (1.0 / body.mass + lever * lever / body.inertia)
    across = -(v[0] - v[2] * y) * ny + (v[1] + v[2] * x) * nx  # along (-ny, nx)
    side = x * nx + y * ny
    drag = _limited(
        -across / (1.0 / body.mass + side * side / body.inertia), body.wall_friction * hit
    )
    jx, jy = hit * nx - drag * ny, hit * ny + drag * nx
    v[0] += jx / body.mass
    v[1] += jy / body.mass
    v[2] += (x * jy - y * jx) / body.inertia

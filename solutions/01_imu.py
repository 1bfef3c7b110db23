# %% [markdown]
# # 01 · IMU: which way is up, and where does the robot look?
#
# You turn the raw numbers of a phone's gyroscope and accelerometer into roll, pitch and yaw:
# calibration first, then the Mahony filter.
#
# | | |
# |---|---|
# | Time | 3 to 4 hours |
# | You need | chapter 00, vectors, Python functions with NumPy |
# | Points | 21: six functions, two numbers, one challenge |
# | Your robot gains | `calibrate_gyro`, `calibrate_accelerometer`, `fit_ellipsoid`, `gravity_direction`, `mahony_step`, `euler_angles` |

# %%
import numpy as np

from robocon_course import files, geometry, imu, worlds
from robocon_course.autopilot import attitude_angles
from robocon_course.exercises import answer, begin, check, hint, robot_parts, status
from robocon_course.view import explore, figure, pictures, plots, show

student = begin("imu", student=None)  # None: the number you gave in chapter 00
world = worlds.imu_world(student)

# %% [markdown]
# ## 1. Where this part sits

# %%
show(
    pictures.draw_system(here="01"),
    "Calibration and attitude are the first two boxes between Observation and Command; odometry, "
    "swerve and planning come after them.",
)

# %% [markdown]
# ## 2. See it work
#
# The course's own parts on a match of yours: 180 seconds, two ramps, hard braking.
# Yaw is where the robot looks. Pitch and roll show the ramps.

# %%
time = np.arange(len(world.gyro)) * world.dt
still_bias = imu.calibrate_gyro(world.still).bias
gyro = world.gyro - still_bias
accel = imu.calibrate_accelerometer(world.rests).apply(world.accel)
gains = imu.MahonyGains(k_p=0.3, k_i=0.0, gate=0.02)
reference = imu.estimate_attitude(gyro, accel, world.dt, gains=gains)

# %%
truth = imu.euler_angles(world.truth)
tilt = np.degrees(imu.inclination_error(reference.quaternions, world.truth))
last = np.degrees(geometry.wrap_angle(reference.yaw[-1] - truth[-1, 2]))
show(
    plots.plot_angles(time, {"reference": imu.euler_angles(reference.quaternions)}, truth),
    f"Roll, pitch and yaw over {time[-1]:.0f} s. The vertical is off by "
    f"{np.sqrt(np.mean(tilt**2)):.2f}° RMS, the yaw by {last:.2f}° at the end.",
)

# %% [markdown]
# ## 3. Two sensors, two lies
#
# A **gyroscope** says how fast the robot turns, a hundred times a second.
# Add it all up and you have the angle. But it has a *bias*: it is off by a nearly constant amount.
#
# An **accelerometer** measures every push on it, but not gravity itself. At rest only the table
# pushes: 9.81 m/s², upwards. So it knows where up is. But when the robot brakes, the push of the
# brakes joins in, and up seems to lie elsewhere.
#
# One is good for a second, the other for an hour. The chapter mixes them.
#
# | symbol | meaning | unit, frame |
# |---|---|---|
# | $\omega$ `gyro` | angular rate | rad/s, body |
# | $a$ `accel` | specific force: acceleration plus what holds the sensor up | m/s², body |
# | $b$ `bias` | what a sensor says too much | as the sensor |
# | $s$ `scale` | factor from raw to true | m/s² per raw unit |
# | $q$ `quaternion` | attitude $(w, x, y, z)$, turns body vectors into the map | – |
# | $\otimes$ | product of quaternions: one turn after the other | – |
# | $\hat a$, $v$ | measured and estimated up, vectors of length 1 | body |
# | $e$ | their cross product: how far they are apart | body |
# | $k_p$, $k_i$, $i$ | gains of the filter, and its integral | 1/s, 1/s², rad/s |
# | $\omega_c$ | corrected rate | rad/s, body |
# | `gate` | how far a sample's length may be from $g$ to count | m/s² |
# | $\Delta t$ `dt` | time since the last sample | s |
#
# **Tilt error** is the angle between the true vertical and the estimated one.
# **RMS** is the root of the mean square: a typical size that does not care about signs.
#
# Body axes: x forward, y left, z up. A left turn is positive.

# %%
part = slice(0, 3000)
show(
    plots.plot_imu(time[part], world.gyro[part], world.accel[part]),
    f"The first 30 s of your match: rates up to {np.degrees(np.abs(world.gyro[part]).max()):.0f} deg/s, "
    f"and a vertical specific force near {world.accel[part, 2].mean():.2f} m/s²; g is 9.81 m/s², "
    "the rest is bias and scale.",
)

# %% [markdown]
# ## 4. Gyroscope: the bias
#
# Before the match the robot stands still for 15 to 20 seconds.
# It turns at 0 rad/s. So the mean of what the gyroscope says is its bias:
#
# $$b = \frac{1}{N}\sum_{k=1}^{N} \omega_k$$

# %%
example = imu.read_log(files.data_file("imu/still.csv"))
example_bias = imu.calibrate_gyro(example.gyro).bias
show(
    plots.plot_still(example.time, example.gyro, example_bias),
    "Another robot's gyroscope at rest for 20 s: noise around a bias of "
    + ", ".join(f"{axis} {rate:.3f}" for axis, rate in zip("xyz", np.degrees(example_bias)))
    + " deg/s.",
)

# %% [markdown]
# But was the robot really still? Somebody bumps into it, and the turn hides in the mean.
# Cut the log into blocks of 50 samples. At rest all block means are alike.

# %% [markdown]
# ### Exercise: gyroscope bias (3 points)
#
# Return `imu.GyroCalibration(bias=…, noise=…)`; the noise is the standard deviation of each axis.
#
# If a block's mean is more than 0.02 rad/s away from the median of all block means, the log moved:
# raise a `ValueError` whose message names the first row of the first such block.


# %% exercise="imu.calibrate_gyro"
def calibrate_gyro(still):
    """Gyroscope bias from a log at rest.

    still : (n, 3) array [rad/s, body], n ≥ 100
    returns : imu.GyroCalibration(bias=(3,) [rad/s], noise=(3,) [rad/s])
    raises : ValueError, if the log moved; the message says in which row
    """
    ### BEGIN SOLUTION
    whole = len(still) // 50 * 50
    blocks = still[:whole].reshape(-1, 50, 3).mean(axis=1)
    off = np.abs(blocks - np.median(blocks, axis=0)).max(axis=1)
    if off.max() > 0.02:
        row = 50 * int(np.argmax(off > 0.02))
        raise ValueError(f"the log moved at row {row}; keep the robot still and record again")
    return imu.GyroCalibration(bias=still.mean(axis=0), noise=still.std(axis=0))
    ### END SOLUTION


# %% check="imu.calibrate_gyro"
calibrate_gyro = check("imu.calibrate_gyro")

# %% [markdown]
# ### Your number: the bias about z (1 point)
#
# How large is the bias of *your* gyroscope about the vertical axis, in degrees per second?
# Work it out in a cell of your own from `world.still`. Then put the number in place of the dots.

# %% answer="imu.own_bias"
answer(
    "imu.own_bias",
    ### BEGIN SOLUTION
    float(np.degrees(calibrate_gyro(world.still).bias[2])),
    ### END SOLUTION
)

# %% [markdown]
# ## 5. Accelerometer: bias and scale
#
# An accelerometer at rest does not read 0. It reads $g$ on the axis that points up.
# So its bias is not the mean of a log at rest.
#
# Hold one axis up, then down:
#
# $$a_{up} = \frac{g}{s} + b, \qquad a_{down} = -\frac{g}{s} + b$$
#
# Half the sum is the bias. The difference gives the scale:
#
# $$b = \frac{a_{up} + a_{down}}{2}, \qquad s = \frac{2g}{a_{up} - a_{down}}, \qquad a_{true} = (a_{raw} - b)\, s$$

# %% [markdown]
# ### Exercise: six positions (2 points)
#
# Six rows: the mean of each resting position, in any order.


# %% exercise="imu.calibrate_accelerometer"
def calibrate_accelerometer(rests, gravity=9.80665):
    """Bias and scale from six resting positions, each axis once up and once down.

    rests : (6, 3) array [raw unit, body]
    gravity : float [m/s²]
    returns : imu.AccelerometerCalibration(bias=(3,) [raw unit], scale=(3,) [m/s² per raw unit])
    """
    ### BEGIN SOLUTION
    up, down = rests.max(axis=0), rests.min(axis=0)
    return imu.AccelerometerCalibration(bias=(up + down) / 2, scale=2 * gravity / (up - down))
    ### END SOLUTION


# %% check="imu.calibrate_accelerometer"
calibrate_accelerometer = check("imu.calibrate_accelerometer")

# %% [markdown]
# ### When no axis was ever vertical
#
# Six exact positions need a flat table and patience. A slow turn in the hand is easier.
# True samples at rest lie on a sphere of radius $g$. Bias shifts it, scale stretches it: an ellipsoid
#
# $$A x^2 + B y^2 + C z^2 + D x + E y + F z = 1$$
#
# It is linear in its six unknowns, so least squares finds them. One row per sample,
# $(x^2, y^2, z^2, x, y, z)$, and 1 on the right: `np.linalg.lstsq(rows, ones, rcond=None)[0]` is
# $(A, B, C, D, E, F)$.
#
# Now complete the square: $A x^2 + D x = A (x - b_x)^2 - A b_x^2$ with $b_x = -D/(2A)$.
# The centre is the bias. Moved to the other side, the three $A b_x^2$ join the 1:
#
# $$A (x - b_x)^2 + B (y - b_y)^2 + C (z - b_z)^2 = r, \qquad r = 1 + A b_x^2 + B b_y^2 + C b_z^2$$
#
# The half axis along x is $\sqrt{r/A}$ long, and should be $g$: $s_x = g / \sqrt{r/A}$. The same
# for y and z.

# %% [markdown]
# ### Exercise: fit the ellipsoid (3 points)


# %% exercise="imu.fit_ellipsoid"
def fit_ellipsoid(samples, gravity=9.80665):
    """Bias and scale from samples in many directions.

    samples : (n, 3) array [raw unit, body], slow turns about all three axes
    gravity : float [m/s²]
    returns : imu.AccelerometerCalibration(bias=(3,), scale=(3,))
    """
    ### BEGIN SOLUTION
    unit = np.abs(samples).max()  # numbers near 1 keep the equations well scaled
    x = samples / unit
    found = np.linalg.lstsq(np.hstack([x**2, x]), np.ones(len(x)), rcond=None)[0]
    square, linear = found[:3], found[3:]
    centre = -linear / (2 * square)
    half_axes = np.sqrt((1 + square @ centre**2) / square)
    return imu.AccelerometerCalibration(bias=centre * unit, scale=gravity / (half_axes * unit))
    ### END SOLUTION


# %% check="imu.fit_ellipsoid"
fit_ellipsoid = check("imu.fit_ellipsoid")

# %%
fit = fit_ellipsoid(world.turns)
raw, corrected = world.turns[::20], fit.apply(world.turns[::20])
raw_length, true_length = (np.linalg.norm(v, axis=1) for v in (raw, corrected))
show(
    plots.plot_sphere(raw, corrected),
    f"Slow turns of your sensor, held askew. The length of the vector goes from {raw_length.min():.2f} to "
    f"{raw_length.max():.2f} m/s² raw, and from {true_length.min():.2f} to "
    f"{true_length.max():.2f} m/s² corrected; g is 9.81 m/s².",
)

# %% [markdown]
# ## 6. An attitude in four numbers
#
# Any attitude is one turn by an angle $\alpha$ about one axis $u$ (of length 1).
# A **quaternion** stores half the angle:
#
# $$q = (w, x, y, z) = \big(\cos\tfrac{\alpha}{2},\ u \sin\tfrac{\alpha}{2}\big)$$
#
# It has length 1. Four numbers, no angle that jumps, and one turn after another is a product,
# $q_1 \otimes q_2$. The rotation matrix of $q$ turns body vectors into the map:
#
# $$R(q) = \begin{pmatrix}
# w^2+x^2-y^2-z^2 & 2(xy - wz) & 2(xz + wy) \\
# 2(xy + wz) & w^2-x^2+y^2-z^2 & 2(yz - wx) \\
# 2(xz - wy) & 2(yz + wx) & w^2-x^2-y^2+z^2 \end{pmatrix}$$

# %%
quarter_left = geometry.quaternion_from_euler(0.0, 0.0, np.pi / 2)
print(f"a quarter turn left about z: q = {quarter_left.round(3)}")
print(f"the body's x axis in the map: {geometry.rotate(quarter_left, [1.0, 0.0, 0.0]).round(3)}")
half_left = geometry.quaternion_multiply(quarter_left, quarter_left)
print(f"two of them, one after the other: q = {half_left.round(3)}, half a turn")

# %% [markdown]
# ### Where up is
#
# The filter must know what the accelerometer *should* say for an attitude $q$.
# Level, it is $(0, 0, 1)$. For any $q$ it is the map's z axis seen from the body: the third **row**
# of $R(q)$, since rows are map axes in body coordinates.
#
# $$v = \begin{pmatrix} 2(xz - wy) \\ 2(wx + yz) \\ w^2 - x^2 - y^2 + z^2 \end{pmatrix}$$

# %% [markdown]
# ### Exercise: gravity direction (1 point)


# %% exercise="imu.gravity_direction"
def gravity_direction(quaternion):
    """Up, seen from the body: what an accelerometer at rest reads, divided by g.

    quaternion : (4,) array (w, x, y, z), body -> map
    returns : (3,) array of length 1
    """
    ### BEGIN SOLUTION
    w, x, y, z = quaternion
    return np.array([2 * (x * z - w * y), 2 * (w * x + y * z), w * w - x * x - y * y + z * z])
    ### END SOLUTION


# %% check="imu.gravity_direction"
gravity_direction = check("imu.gravity_direction")

# %% [markdown]
# ## 7. The Mahony filter
#
# Measured up is $\hat a = a / |a|$, estimated up is $v$.
# Their cross product is the axis to turn about, and the sine of the angle between them.
# A proportional and an integral part feed it back into the gyroscope:
#
# $$e = \hat a \times v \qquad i \leftarrow i + k_i\, e\, \Delta t \qquad \omega_c = \omega + k_p\, e + i$$
#
# $$q \leftarrow q + \tfrac{1}{2}\, q \otimes (0, \omega_c)\, \Delta t, \qquad q \leftarrow \frac{q}{|q|}$$
#
# The ½ is there because a quaternion holds half the angle.
#
# Large $k_p$ trusts the accelerometer, small $k_p$ the gyroscope. With $k_i > 0$ the integral $i$
# slowly becomes the bias with its sign reversed.
#
# **Why no magnetometer?** It would give the yaw. But motors and servos are magnets:
# on the robot the needle follows the motors. Yaw comes from the gyroscope alone, and later from
# wheels and LiDAR.

# %% [markdown]
# ### Exercise: one step of the filter (4 points)
#
# A sample may be missing. Without a finite gyroscope sample, return the state as it is.
#
# An accelerometer sample may hold more than gravity. The error is 0 if the sample is not finite, if its
# length is 0, or if its length is further than `gains.gate` from 9.80665 m/s².
#
# `geometry.quaternion_multiply(a, b)` is $a \otimes b$.


# %% exercise="imu.mahony_step"
def mahony_step(state, gyro, accel, dt, gains):
    """Attitude after one more sample.

    state : imu.MahonyState(quaternion=(4,), integral=(3,) [rad/s])
    gyro, accel : (3,) arrays [rad/s, m/s², body]
    dt : float [s]
    gains : imu.MahonyGains(k_p [1/s], k_i [1/s²], gate [m/s²])
    returns : imu.MahonyState
    """
    ### BEGIN SOLUTION
    q, integral = state.quaternion, state.integral
    if not np.isfinite(gyro).all():
        return state
    error, length = np.zeros(3), np.linalg.norm(accel)
    if 0 < length < np.inf and abs(length - 9.80665) <= gains.gate:
        error = np.cross(accel / length, gravity_direction(q))
    integral = integral + gains.k_i * error * dt
    rate = gyro + gains.k_p * error + integral
    q = q + 0.5 * dt * geometry.quaternion_multiply(q, np.array([0.0, *rate]))
    return imu.MahonyState(q / np.linalg.norm(q), integral)
    ### END SOLUTION


# %% check="imu.mahony_step"
mahony_step = check("imu.mahony_step")

# %% [markdown]
# The course's own filter is the same text on plain numbers, compiled.
# `imu.mahony_update.py_func??` in a cell of your own shows it, once your answer was accepted.

# %% [markdown]
# ## 8. Angles for people
#
# A quaternion is good for computing and bad for reading. Turn it into three angles:
# first yaw about z, then pitch about the new y, then roll about the new x.
#
# $$\text{roll} = \operatorname{atan2}\big(2(wx + yz),\ 1 - 2(x^2 + y^2)\big)$$
# $$\text{pitch} = \arcsin\big(2(wy - xz)\big)$$
# $$\text{yaw} = \operatorname{atan2}\big(2(wz + xy),\ 1 - 2(y^2 + z^2)\big)$$
#
# Nose down is positive pitch, since y points left.

# %% [markdown]
# ### Exercise: Euler angles (2 points)


# %% exercise="imu.euler_angles"
def euler_angles(quaternion):
    """Roll, pitch and yaw.

    quaternion : (4,) array (w, x, y, z), body -> map
    returns : (3,) array [rad]
    """
    ### BEGIN SOLUTION
    w, x, y, z = quaternion
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - x * z), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.array([roll, pitch, yaw])
    ### END SOLUTION


# %% check="imu.euler_angles"
euler_angles = check("imu.euler_angles")

# %% [markdown]
# ## 9. Play: how much to trust whom
#
# The first minute of your match, with the gyroscope's bias left in.
# Raise `k_p`: bias matters less, pushes matter more. Raise `k_i`: the filter learns the bias.
# Lower `gate`: only samples that are as long as $g$, within the gate, may correct.
#
# **Task.** Bring the tilt error below 1.2° RMS. Which of the three matters most, and why?


# %%
def draw_gains(k_p, k_i, gate):
    """Tilt error of one choice of gains, on raw gyroscope data."""
    minute, chosen = slice(0, 6000), imu.MahonyGains(k_p, k_i, gate)
    log = imu.estimate_attitude(world.gyro[minute], accel[minute], world.dt, gains=chosen)
    error = imu.inclination_error(log.quaternions, world.truth[minute])
    rms, worst = np.degrees([np.sqrt(np.mean(error**2)), error.max()])
    fig = plots.plot_tilt_error(time[minute], {"raw gyroscope": error})
    text = f"k_p = {k_p:g}, k_i = {k_i:g}, gate = {gate:g} m/s²"
    return fig, f"{text}: tilt error {rms:.2f}° RMS, {worst:.2f}° at worst."


explore(
    draw_gains, k_p=(0.0, 5.0, 0.1, 1.0), k_i=(0.0, 0.5, 0.01, 0.0), gate=(0.01, 1.0, 0.01, 1.0)
)

# %% [markdown]
# ## 10. Drift
#
# Gravity corrects the tilt. Nothing corrects the yaw: its bias adds up, second after second.

# %%
raw_log = imu.estimate_attitude(world.gyro, accel, world.dt)
drift = geometry.wrap_angle(np.stack([raw_log.yaw, reference.yaw]) - truth[:, 2])
fig, ax = figure(7.0, 3.2)
ax.plot(time, np.degrees(drift[0]), color=plots.RAW, label="raw gyroscope")
ax.plot(time, np.degrees(drift[1]), color=plots.REFERENCE, label="bias removed")
ax.set(xlabel="time [s]", ylabel="yaw error [deg]")
ax.legend()
show(
    fig,
    "Yaw error over the match: raw it grows in a straight line as long as the match lasts, "
    f"calibrated it ends at {np.degrees(drift[1, -1]):.2f}°.",
)

# %% [markdown]
# ### Your number: the drift (1 point)
#
# By how many degrees is the yaw of *your* raw log off at the end of the match?
# Estimate minus truth, left positive. The figure shows it; `raw_log` and `truth` hold it exactly.

# %% answer="imu.own_drift"
answer(
    "imu.own_drift",
    ### BEGIN SOLUTION
    float(np.degrees(drift[0, -1])),
    ### END SOLUTION
)

# %% [markdown]
# ## 11. Break it
#
# What goes wrong on real robots, one failure at a time, and what it costs.
# The filter is the course's, with the gains of section 2.


# %%
def tilt_rms(gyro, accel, dt=world.dt, gains=gains):
    """RMS tilt error and yaw error at the end [deg] of the filter on a spoilt log."""
    log = imu.estimate_attitude(gyro, accel, dt, gains=gains)
    error = imu.inclination_error(log.quaternions, world.truth)
    yaw = geometry.wrap_angle(log.yaw[-1] - truth[-1, 2])
    return np.degrees(np.sqrt(np.mean(error**2))), np.degrees(yaw)


rng = worlds.generator(student, "break it")
all_samples = imu.MahonyGains(k_p=0.3)  # no gate: every accelerometer sample counts
failures = {"good log": tilt_rms(gyro, accel)}

# %% [markdown]
# **Bias left in.** Gyroscope and accelerometer pull apart, and rest between their two opinions.
#
# **Acceleration taken for tilt.** Without the gate, every braking tips the horizon.
# A larger `k_p` makes it worse.

# %%
failures["gyro bias left in"] = tilt_rms(world.gyro, accel)
failures["accel not calibrated"] = tilt_rms(gyro, world.accel, gains=all_samples)
failures["push taken for tilt"] = tilt_rms(gyro, accel, gains=all_samples)
failures["the same with k_p = 5"] = tilt_rms(gyro, accel, gains=imu.MahonyGains(k_p=5.0))

# %% [markdown]
# **Missing samples** arrive as NaN. The filter bridges and counts them. Believed once, a NaN would
# stay in the attitude for good. What turned during a gap is lost to the yaw.
#
# **Saturation.** A hit beyond the sensor's range reads as the range: 39 m/s² that are not there.
#
# **Wrong dt.** The code believes in 200 Hz, the phone sends 100 Hz. Every angle comes out half
# as large. The accelerometer repairs the tilt, nobody repairs the yaw.

# %%
gappy, hit = gyro.copy(), accel.copy()
gappy[rng.random(len(gappy)) < 0.05] = np.nan
hit[rng.random(len(hit)) < 0.05] = [39.2, 39.2, -39.2]
failures["5 % of gyro missing"] = tilt_rms(gappy, accel)
failures["5 % hits, no gate"] = tilt_rms(gyro, hit, gains=all_samples)
failures["5 % hits, gated"] = tilt_rms(gyro, hit)
failures["dt half of the truth"] = tilt_rms(gyro, accel, dt=world.dt / 2)
for name, (rms, yaw) in failures.items():
    print(f"{name:24s} tilt error {rms:5.2f}° RMS, yaw off by {abs(yaw):5.1f}° at the end")

# %%
fig, ax = figure(7.0, 3.6)
names = list(failures)[::-1]
values = [failures[name][0] for name in names]
yaws = [abs(failures[name][1]) for name in names]
well = [value < 1.0 and yaw < 5.0 for value, yaw in zip(values, yaws)]
ax.barh(names, values, color=[plots.REFERENCE if w else plots.WARN for w in well])
for row, (value, yaw) in enumerate(zip(values, yaws)):
    ax.text(value, row, f" {value:.2f}°, yaw {yaw:.0f}°", va="center")
ax.set(
    xlabel="tilt error, RMS [deg]; beside it the yaw error at the end", xlim=(0, 1.3 * max(values))
)
ax.grid(axis="y", visible=False)
worst = names[int(np.argmax(values))]
show(
    fig, f"Tilt error of each failure, from {min(values):.2f}° to {max(values):.2f}° RMS ({worst})."
)

# %% [markdown]
# ## 12. Check the source
#
# The filter was taken from a thesis about a real robot that won. Two printed formulas do not work.
#
# **Half of gravity.** Printed are $v_x = 2(xz - wy)$, $v_y = 2(wx + yz)$ and
# $v_z = w^2 - 0.5 + z^2$. For a unit quaternion $w^2 - x^2 - y^2 + z^2 = 2(w^2 + z^2) - 1$, so this
# $v_z$ is half of what belongs to the other two. The filter rests where $\hat a \parallel v$:
#
# $$\tan(\text{estimate}) = \tfrac{1}{2}\tan(\text{true})$$


# %%
def settle(true_roll, third):
    """Roll at which the filter settles when v_z is multiplied by ``third`` [rad]."""
    accel = np.array([0.0, np.sin(true_roll), np.cos(true_roll)])
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for _ in range(2000):
        v = imu.gravity_direction(q) * [1.0, 1.0, third]
        rate = 5.0 * np.cross(accel, v)
        q = q + 0.005 * geometry.quaternion_multiply(q, np.array([0.0, *rate]))
        q /= np.linalg.norm(q)
    return imu.euler_angles(q)[0]


true_rolls = np.radians([5, 10, 20, 30, 45, 60])
printed = np.degrees([settle(roll, 0.5) for roll in true_rolls])
mended = np.degrees([settle(roll, 1.0) for roll in true_rolls])

# %%
fig, ax = figure(7.0, 3.4)
curve = np.linspace(0, 65, 100)
half = np.degrees(np.arctan(np.tan(np.radians(curve)) / 2))
ax.plot(curve, half, color="0.7", label="half the tangent")
ax.plot(np.degrees(true_rolls), printed, "o", color=plots.WARN, label="as printed")
ax.plot(np.degrees(true_rolls), mended, "s", color=plots.REFERENCE, label="v_z doubled")
ax.set(xlabel="true roll [deg]", ylabel="roll the filter settles at [deg]")
ax.legend()
show(
    fig,
    f"With the printed formula a roll of 20° settles at {printed[2]:.1f}° and 45° at "
    f"{printed[4]:.1f}°; with v_z doubled at {mended[2]:.1f}° and {mended[4]:.1f}°.",
)

# %% [markdown]
# **The mean is not the accelerometer's bias.** Printed is: average at rest and subtract, "so that the
# output becomes zero". That subtracts gravity. Flat on the table nothing is left to find up by, and
# on its side the sensor seems to be pushed down as well.

# %%
flat = world.rests[np.argmax(world.rests[:, 2])]
on_its_side = world.rests[np.argmax(world.rests[:, 0])]
calibration = calibrate_accelerometer(world.rests)
for name, rest in {"flat on the table": flat, "on its side, x up": on_its_side}.items():
    printed_way, six_positions = rest - flat, (rest - calibration.bias) * calibration.scale
    print(
        f"{name}: minus the mean {printed_way.round(2)}, six positions {six_positions.round(2)} m/s²"
    )

# %% [markdown]
# ## 13. Link-up: your parts in the robot
#
# Three rungs: an ideal IMU, your own noisy one, and a rough link with gaps and hits.
# A **rung** is one step of this ladder. Each runs once on the course's parts and once on yours, as
# far as they were accepted. On the rough rung the yaw loses what turned during the gaps.

# %%
mine, course = robot_parts("mixed"), robot_parts("reference")


def run(parts, rung):
    """Roll, pitch and yaw of a rung, and the RMS error of roll and pitch [deg]."""
    angles = attitude_angles(
        parts, rung.still, rung.rests, rung.gyro, rung.accel, dt=world.dt, gains=gains
    )
    off = geometry.wrap_angle(angles - imu.euler_angles(rung.truth))[:, :2]
    return angles, np.degrees(np.sqrt(np.mean(off**2)))


# %%
rungs = worlds.imu_rungs(student)
print(f"Parts: {mine.label}")
for name, rung in rungs.items():
    ours, yours = run(course, rung), run(mine, rung)
    print(
        f"{name:6s} roll and pitch off by {ours[1]:.2f}° RMS on the course's parts, {yours[1]:.2f}° on yours"
    )

# %%
rough = rungs["rough"]
show(
    plots.plot_angles(
        np.arange(len(rough.gyro)) * world.dt,
        {"reference": run(course, rough)[0]} | ({"mine": run(mine, rough)[0]} if mine.mine else {}),
        imu.euler_angles(rough.truth),
    ),
    f"The rough rung on the course's parts and on yours ({mine.label}): roll and pitch off by "
    f"{run(course, rough)[1]:.2f}° and {run(mine, rough)[1]:.2f}° RMS.",
)

# %% [markdown]
# ## 14. A phone as IMU
#
# Apps that stream sensors over UDP turn a phone into the robot's IMU. Give the app this computer's
# address and a port above 1024, and choose CSV or JSON. `imu.listen(port)` yields one sample after
# the other, and skips and counts what it cannot read. Each line is `t,gx,gy,gz,ax,ay,az` or
# `{"t": 0.01, "gyro": [0, 0, 0], "accel": [0, 0, 9.8]}`, in s, rad/s and m/s².
#
# Most phones have x to the right of the screen, y to its top and z out of it. Lay the phone flat with
# its top to the left of the robot, and phone x points forward.
#
# Here the notebook plays the phone, over the loopback address.

# %%
import socket

with imu.listen(0, host="127.0.0.1", timeout=2.0) as phone:
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for k in range(5):
        sender.sendto(f"{k * 0.01},0,0,0.1,0,0,9.81".encode(), ("127.0.0.1", phone.port))
    sender.sendto(b"not a sample", ("127.0.0.1", phone.port))
    sender.close()
    samples = list(phone)
attitude = imu.AttitudeFilter(gains)
for sample in samples:
    attitude.update(sample.gyro, sample.accel, 0.01)
up = imu.gravity_direction(attitude.state.quaternion).round(2)
print(f"{len(samples)} samples, {phone.malformed} malformed line skipped; up is {up} in the body")

# %% [markdown]
# ## 15. Challenge: a rough drive (4 points)
#
# Gaps in the radio link (NaN), hits that saturate the accelerometer, braking, a bias nobody measured.
# Write your own estimator. Each drive begins with one second at rest.
# It is judged by the RMS tilt error of the worst of three drives:
# up to 0.5° earns all points, up to 1.2° half of them. The plain filter is off by about 3°.
#
# Ideas: use the second at rest, interpolate the rate over a gap, leave out samples that are not
# as long as $g$, tune the gains.


# %% exercise="imu.attitude_in_motion"
def attitude_in_motion(gyro, accel, dt):
    """Attitude during a rough drive.

    gyro, accel : (n, 3) arrays [rad/s, m/s², body]; rows may be NaN
    dt : float [s]
    returns : (n, 4) array of quaternions (w, x, y, z), body -> map
    """
    ### BEGIN SOLUTION
    seen = np.flatnonzero(np.isfinite(gyro).all(axis=1))
    rows = np.arange(len(gyro))
    bridged = np.column_stack([np.interp(rows, seen, gyro[seen, k]) for k in range(3)])
    rates = bridged - np.nanmean(gyro[:80], axis=0)
    gains = imu.MahonyGains(k_p=0.3, k_i=0.0, gate=0.02)
    return imu.estimate_attitude(rates, accel, dt, gains=gains).quaternions
    ### END SOLUTION


# %% check="imu.attitude_in_motion"
attitude_in_motion = check("imu.attitude_in_motion")

# %% [markdown]
# ## 16. Summary
#
# - A gyroscope drifts, an accelerometer is pushed around. Together they know where up is.
# - Calibrate before the match: mean at rest for the gyroscope, six positions or slow turns for
#   the accelerometer. Refuse a log that moved.
# - Mahony: cross product, PI feedback, integrate, normalise.
# - Yaw drifts. Only another sensor can stop that: the next chapter's wheels.
#
# **Ask yourself.** Why is the cross product zero when the attitude is right?
# What does $k_i$ learn while the robot brakes for a long time? What happens upside down?
# Why does the yaw not profit from the accelerometer? What would a wrong sign of $e$ do?
#
# ## Glossary
#
# | English | Bahasa Indonesia |
# |---|---|
# | gyroscope | giroskop |
# | accelerometer | akselerometer |
# | bias | bias, galat tetap |
# | scale factor | faktor skala |
# | attitude | orientasi |
# | roll, pitch, yaw | guling, angguk, geleng |
# | at rest | diam |
# | drift | hanyutan |
# | noise | derau |
# | least squares | kuadrat terkecil |
#
# ## Reading
#
# R. Mahony, T. Hamel, J.-M. Pflimlin: *Nonlinear Complementary Filters on the Special Orthogonal
# Group*, IEEE Transactions on Automatic Control 53(5), 2008. Section IV is this filter.
#
# Source of the robot and of the two printed formulas: thesis on the autonomous localisation and
# navigation of a swerve-drive robot, Universitas Negeri Yogyakarta, 2024, chapter "Integrasi
# Gyroscope dan Accelerometer Menggunakan Mahony Filter".
#
# ## Where you are

# %%
status()

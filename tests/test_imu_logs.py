"""Chapter 01 on real input: logs recorded by other people, files by any hand, a phone over UDP."""

from __future__ import annotations

import csv
import socket
import threading
import time

import numpy as np
import pytest
from scipy.io import loadmat

from robocon_course import imu

G = 9.80665


# --- recordings -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def broad(recordings):
    """BROAD, trial 02: gyro, accel, true attitude, dt, and which rows count."""
    file = recordings / "imu_broad" / "02_undisturbed_slow_rotation_B.mat"
    log = loadmat(file, squeeze_me=True)
    moving = log["movement"] == 1
    return log["imu_gyr"], log["imu_acc"], log["opt_quat"], 1.0 / log["sampling_rate"], moving


@pytest.fixture(scope="module")
def imucal(recordings):
    """imucal's example session: section name -> rows of acc x, y, z, gyr x, y, z."""
    with open(recordings / "imu_sixpos" / "annotated_session.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    sections: dict[str, list[list[float]]] = {}
    for row in rows:
        numbers = [float(row[f"{s}_{axis}"]) for s in ("acc", "gyr") for axis in "xyz"]
        sections.setdefault(row["part"], []).append(numbers)
    return {part: np.array(section) for part, section in sections.items()}


def inclination_rms(gyro, accel, truth, dt, counted):
    log = imu.estimate_attitude(gyro, accel, dt, gains=imu.MahonyGains(0.5, 0.0))
    error = imu.inclination_error(log.quaternions, truth)[counted]
    return np.degrees(np.sqrt(np.nanmean(error**2)))


def test_broad_inclination_is_within_0_70_degrees_raw_and_0_40_without_the_rest_bias(broad):
    gyro, accel, truth, dt, moving = broad
    rest = imu.calibrate_gyro(gyro[: np.argmax(moving)], dt=dt)
    assert inclination_rms(gyro, accel, truth, dt, moving) <= 0.70
    assert inclination_rms(rest.apply(gyro), accel, truth, dt, moving) <= 0.40


def test_broad_rest_passes_and_every_stretch_of_movement_is_refused(broad):
    gyro, _, _, dt, moving = broad
    start = int(np.argmax(moving))
    second = round(1.0 / dt)
    imu.calibrate_gyro(gyro[: 20 * second], dt=dt)
    with pytest.raises(imu.MovedError) as refusal:
        imu.calibrate_gyro(gyro[: start + 5 * second], dt=dt)
    assert abs(refusal.value.rows[0] - start) < 2 * second
    for first in range(start, len(gyro) - 20 * second, 20 * second):
        if moving[first : first + 20 * second].mean() > 0.5:
            with pytest.raises(imu.MovedError):
                imu.calibrate_gyro(gyro[first : first + 20 * second], dt=dt)


def test_the_excerpt_as_text_reads_and_keeps_its_tilt(recordings):
    path = recordings / "imu_broad" / "02_slow_rotation_B_20s_to_80s.csv"
    log = imu.read_log(path)
    table = np.genfromtxt(path, delimiter=",", names=True)
    truth = np.column_stack([table[f"q_{part}"] for part in "wxyz"])
    assert len(log.time) == 17_143
    assert np.array_equal(log.gyro[:, 2], table["gyr_z"])
    attitude = imu.estimate_attitude(log.gyro, log.accel, log.dt)
    error = np.degrees(imu.inclination_error(attitude.quaternions, truth))
    assert np.sqrt(np.mean(error[table["moving"] == 1] ** 2)) < 0.9


def test_imucal_rests_give_the_makers_offsets_and_scales(imucal):
    """Ferraris 1995 as imucal has it: half the sum and half the difference of the two rests."""
    up, down = (
        np.array([imucal[f"{axis}_{side}"][:, :3].mean(axis=0) for axis in "xyz"]) for side in "pa"
    )
    offset = np.diag(up + down) / 2
    counts_per_unit = np.diag(up - down) / (2 * G)
    found = imu.calibrate_accelerometer(np.vstack([up, down]))
    np.testing.assert_allclose(found.bias, offset, atol=1e-3)
    np.testing.assert_allclose(found.scale, 1.0 / counts_per_unit, rtol=5e-4)


def test_imucal_rests_are_still_in_counts_and_its_turns_are_not(imucal):
    for part, section in imucal.items():
        if part.endswith("_rot"):
            with pytest.raises(imu.MovedError):
                imu.calibrate_gyro(section[:, 3:])
        else:
            imu.calibrate_gyro(section[:, 3:])


def test_the_ellipsoid_fit_on_imucal_rests_agrees_with_the_formula(imucal):
    rests = [section[:, :3].mean(axis=0) for part, section in imucal.items() if "_rot" not in part]
    formula, fit = imu.calibrate_accelerometer(rests), imu.fit_ellipsoid(rests)
    np.testing.assert_allclose(fit.bias, formula.bias, atol=1.0)  # counts of about 2000 per g
    np.testing.assert_allclose(fit.scale, formula.scale, rtol=2e-3)


# --- files ------------------------------------------------------------------------------------

HEADER = "t_s,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z"
ROWS = ["0.00,1,2,3,4,5,6", "0.01,1,2,3,4,5,7", "0.03,1,2,3,4,5,8"]


@pytest.fixture
def log_file(tmp_path):
    def write(*lines: str, encoding: str = "utf-8"):
        path = tmp_path / "log.csv"
        path.write_bytes("\n".join(lines).encode(encoding))
        return path

    return write


def test_a_plain_log_by_hand(log_file):
    log = imu.read_log(log_file(HEADER, *ROWS))
    assert log.time.tolist() == [0.0, 0.01, 0.03]
    assert log.gyro.tolist() == [[1.0, 2.0, 3.0]] * 3
    assert log.accel[:, 2].tolist() == [6.0, 7.0, 8.0]
    assert log.dt == pytest.approx([0.015, 0.01, 0.02])


@pytest.mark.parametrize(
    "header, unit",
    [
        ("time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z", (1.0, 1.0, 1.0)),
        ("T, GX, GY, GZ, AX, AY, AZ", (1.0, 1.0, 1.0)),
        ("t,wx,wy,wz,ax,ay,az", (1.0, 1.0, 1.0)),
        ("t,omega_x,omega_y,omega_z,a_x,a_y,a_z", (1.0, 1.0, 1.0)),
        ("time_ms,gyr_x_dps,gyr_y_dps,gyr_z_dps,acc_x_g,acc_y_g,acc_z_g", (1e-3, np.pi / 180, G)),
        ("timestamp_us,gx_deg_s,gy_deg_s,gz_deg_s,ax,ay,az", (1e-6, np.pi / 180, 1.0)),
        ("t_ns,gyrX,gyrY,gyrZ,accX,accY,accZ", (1e-9, 1.0, 1.0)),
        (
            '"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)","Gyroscope z (rad/s)",'
            '"Acceleration x (m/s^2)","Acceleration y (m/s^2)","Acceleration z (m/s^2)"',
            (1.0, 1.0, 1.0),
        ),
    ],
)
def test_many_ways_to_name_the_columns(log_file, header, unit):
    log = imu.read_log(log_file(header, *ROWS))
    found = (log.time[2] / 0.03, log.gyro[0, 1] / 2.0, log.accel[0, 2] / 6.0)
    assert found == pytest.approx(unit)


@pytest.mark.parametrize("mark", [";", "\t", "  "])
def test_other_marks_between_cells(log_file, mark):
    lines = [line.replace(",", mark) for line in (HEADER, *ROWS)]
    assert imu.read_log(log_file(*lines)).accel[2].tolist() == [4.0, 5.0, 8.0]


def test_a_spreadsheet_with_decimal_commas(log_file):
    row = "0,02;1,5;2;3;4;5;9,81"
    log = imu.read_log(log_file(HEADER.replace(",", ";"), row, encoding="utf-8-sig"))
    assert (log.time[0], log.gyro[0, 0], log.accel[0, 2]) == (0.02, 1.5, 9.81)


def test_columns_may_stand_in_any_order_beside_others(log_file):
    log = imu.read_log(
        log_file("az,mag_x,ay,note,ax,gz,gy,gx,t", "6,9,5,hm,4,3,2,1,0", "6,9,5,,4,3,2,1,0.1")
    )
    assert log.gyro[0].tolist() == [1.0, 2.0, 3.0] and log.accel[0].tolist() == [4.0, 5.0, 6.0]


def test_a_time_that_states_its_unit_wins_over_one_that_does_not(log_file):
    header = f"time,seconds_elapsed,{HEADER.partition(',')[2]}"
    log = imu.read_log(log_file(header, "1700000000000000000,0.5,1,2,3,4,5,6"))
    assert log.time.tolist() == [0.5]


def test_empty_and_missing_cells_are_holes_that_the_filter_bridges(log_file):
    log = imu.read_log(log_file(HEADER, ROWS[0], "0.01,1,,3,nan,5,6", "", "# rest", "0.02,1,2"))
    assert np.isnan(log.gyro[1]).tolist() == [False, True, False]
    assert np.isnan(log.accel[2]).all() and np.isnan(log.gyro[2, 2])
    assert imu.estimate_attitude(log.gyro, log.accel, log.dt).rejected == 2


def test_a_file_without_time_takes_the_rate(log_file):
    path = log_file(HEADER.partition(",")[2], "1,2,3,4,5,6", "1,2,3,4,5,6")
    assert imu.read_log(path, rate=50.0).time.tolist() == [0.0, 0.02]
    with pytest.raises(ValueError, match=r"no column for time; .* give the rate"):
        imu.read_log(path)
    with pytest.raises(ValueError, match="rate: must be a positive"):
        imu.read_log(path, rate=0.0)


@pytest.mark.parametrize(
    "lines, sentence",
    [
        ([HEADER.replace("acc_y", "why"), *ROWS], r"no column for acc_y; found t_s, .*why.*Needed"),
        ([HEADER, ROWS[0], "0.01,1,2,oops,4,5,6"], r"row 3, column gyr_z: 'oops' is not a number"),
        ([HEADER, ROWS[0], "", "0.01,1,2,3,4,5,0x"], r"row 4, column acc_z"),
        ([HEADER, ROWS[1], ROWS[0]], r"time runs backwards in row 3 \(0.01 s, then 0 s\)"),
        ([HEADER, ROWS[0], ",1,2,3,4,5,6"], r"row 3 has no time"),
        ([HEADER, "0,1,2,3,4,5,6", "10,1,2,3,4,5,6"], r"10 s apart.*_ms"),
        ([HEADER, "0,1,2,3,4,5,6,7"], r"row 2 has 8 cells, the header 7"),
        ([HEADER], r"no header with rows below it"),
        ([""], r"no header with rows below it"),
        ([ROWS[0], ROWS[1]], r"no column for time, gyr_x, .*found 0.00, 1, 2"),
    ],
)
def test_what_cannot_be_read_is_refused_in_a_sentence(log_file, lines, sentence):
    with pytest.raises(ValueError, match=sentence):
        imu.read_log(log_file(*lines))


def test_bytes_that_are_no_text_and_missing_files_are_refused(tmp_path):
    (tmp_path / "x.png").write_bytes(bytes(range(256)) * 20)
    with pytest.raises(ValueError, match=r"no column for|no header"):
        imu.read_log(tmp_path / "x.png")
    with pytest.raises(FileNotFoundError):
        imu.read_log(tmp_path / "none.csv")


def test_written_angles_read_back(log_file, tmp_path):
    log = imu.read_log(log_file(HEADER, *ROWS))
    attitude = imu.estimate_attitude(log.gyro, log.accel, log.dt)
    imu.write_angles(tmp_path / "angles.csv", log, attitude)
    table = np.genfromtxt(tmp_path / "angles.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["t_s"], log.time, atol=1e-6)
    np.testing.assert_allclose(table["yaw_deg"], np.degrees(attitude.yaw), atol=1e-4)
    np.testing.assert_allclose(table["q_z"], attitude.quaternions[:, 3], atol=1e-8)
    short = imu.ImuLog(log.time[:2], log.gyro[:2], log.accel[:2])
    with pytest.raises(ValueError, match="attitude: has 3 rows, the log 2"):
        imu.write_angles(tmp_path / "angles.csv", short, attitude)


# --- a phone ----------------------------------------------------------------------------------


@pytest.fixture
def phone():
    with imu.listen(0, "127.0.0.1", timeout=5.0) as listener:
        yield listener


def send(listener, *datagrams: bytes) -> None:
    with socket.socket(type=socket.SOCK_DGRAM) as sender:
        for datagram in datagrams:
            sender.sendto(datagram, ("127.0.0.1", listener.port))


LAST = b"9,0,0,0,0,0,0"


def until_last(listener) -> list[imu.Sample]:
    """Samples up to the one with time 9."""
    samples = []
    for sample in listener:
        if sample.time == 9.0:
            return samples
        samples.append(sample)
    raise AssertionError("the last sample never came")


def test_csv_and_json_lines_arrive_as_the_same_samples(phone):
    send(
        phone,
        b"0.01,1,2,3,4,5,6\n0.02, 1, 2, 3, 4, 5, 6\r\n",
        b'{"t": 0.03, "gyro": [1, 2, 3], "accel": [4, 5, 6]}',
        b'0.04,1,2,3,4,5,6\n\n{"accel":[4,5,6],"gyro":[1,2,3],"t":0.05}\n\0',
        LAST,
    )
    samples = until_last(phone)
    assert [sample.time for sample in samples] == [0.01, 0.02, 0.03, 0.04, 0.05]
    assert all(sample.gyro.tolist() == [1, 2, 3] for sample in samples)
    assert all(sample.accel.tolist() == [4, 5, 6] for sample in samples)
    assert (phone.received, phone.malformed) == (6, 0)


MALFORMED = [
    b"hello",
    b"1,2,3",
    b"1,2,3,4,5,6,7,8",
    b"1,2,3,4,5,6,x",
    b"1,2,3,4,5,6,",
    b"nan,2,3,4,5,6,7",
    b"\xff\xfe\x00\x01",
    b"{",
    b"{}",
    b"[1,2,3,4,5,6,7]",
    b'{"t": null, "gyro": [1, 2, 3], "accel": [1, 2, 3]}',
    b'{"t": 1, "gyro": [1, 2], "accel": [1, 2, 3, 4]}',
    b'{"t": 1, "gyro": "123", "accel": [1, 2, 3]}',
    b'{"t": 1, "gyro": [[1], 2, 3], "accel": [1, 2, 3]}',
    b'{"t": 1, "gyro": {"x": 1}, "accel": [1, 2, 3]}',
    b'{"t": 1' + b"0" * 400 + b', "gyro": [1, 2, 3], "accel": [1, 2, 3]}',
    b'{"t": ' + b"[" * 50_000,
    b"7" * 60_000,
]


def test_malformed_lines_are_counted_and_skipped(phone):
    for line in MALFORMED:
        send(phone, line)
    send(phone, b"0.01,1,2,3,4,5,6\n" + MALFORMED[0] + b"\n0.02,1,2,3,4,5,6", LAST)
    assert [sample.time for sample in until_last(phone)] == [0.01, 0.02]
    assert phone.malformed == len(MALFORMED) + 1


def test_a_huge_datagram_of_many_lines_arrives_whole(phone):
    lines = [f"{k / 1000:.3f},1,2,3,4,5,6" for k in range(1, 2501)] + ["", "rubbish"] * 500
    datagram = "\n".join(lines).encode()
    assert len(datagram) > 40_000
    send(phone, datagram, LAST)
    assert len(until_last(phone)) == 2500
    assert phone.malformed == 500


def test_readings_that_are_not_finite_come_through_for_the_filter_to_bridge(phone):
    send(phone, b"1,nan,0,0,0,0,9.8", b'{"t":2,"gyro":[0,0,0],"accel":[null,NaN,Infinity]}', LAST)
    first, second = until_last(phone)
    assert np.isnan(first.gyro[0]) and np.isnan(second.accel[:2]).all()
    stream = imu.AttitudeFilter()
    stream.update([0, 0, 0], [0, 0, G], 0.01)
    for sample in (first, second):
        stream.update(sample.gyro, sample.accel, 0.01)
    assert stream.rejected == 2


def test_silence_ends_the_samples_after_the_timeout():
    with imu.listen(0, "127.0.0.1", timeout=0.05) as listener:
        send(listener, LAST)
        assert len(list(listener)) == 1
        assert list(listener) == []


def test_closing_from_another_thread_ends_a_waiting_loop_at_once():
    listener = imu.listen(0, "127.0.0.1")
    samples: list[imu.Sample] = []
    loop = threading.Thread(target=lambda: samples.extend(listener), daemon=True)
    loop.start()
    send(listener, LAST)
    while not samples and not listener.received:
        time.sleep(0.01)
    threading.Thread(target=listener.close, daemon=True).start()
    loop.join(timeout=5.0)
    assert not loop.is_alive() and len(samples) == 1
    listener.close()  # twice is fine


def test_closing_inside_the_loop_and_leaving_the_block_free_the_port():
    with imu.listen(0, "127.0.0.1", timeout=5.0) as listener:
        send(listener, LAST + b"\n" + LAST)
        next(listener)
        listener.close()
        assert listener.received == 2 and list(listener) == []
    with imu.listen(listener.port, "127.0.0.1") as again:
        assert again.port == listener.port


def test_a_taken_port_and_foolish_arguments_are_refused(phone):
    with pytest.raises(OSError):
        imu.listen(phone.port, "127.0.0.1")
    with pytest.raises(ValueError, match="port: must lie between 0 and 65535, got 70000"):
        imu.listen(70_000)
    with pytest.raises(ValueError, match="timeout: must be a positive"):
        imu.listen(0, timeout=0.0)

"""TFmini Plus: nine bytes a reading.

Source: Benewake, TFmini Plus data sheet SJ-GU-TFmini-Plus-01 A04, frame format and validity.
"""

from __future__ import annotations

from typing import NamedTuple

from robocon_course.robot.hardware import SATURATED, WEAKEST, LidarReading

FRAME_HEAD = b"\x59\x59"
FRAME_SIZE = 9


class LidarFrames(NamedTuple):
    """What was found in a piece of a LiDAR's byte stream.

    Attributes
    ----------
    readings : list of LidarReading
        Oldest first, their time as given.
    bad : int
        Heads without a matching checksum behind them.
    rest : bytes
        Beginning of a frame that is not complete; put it in front of the next piece.
    """

    readings: list[LidarReading]
    bad: int
    rest: bytes


def encode_lidar(reading: LidarReading, *, per_metre: int = 100) -> bytes:
    """The nine bytes that a TFmini Plus sends for a reading.

    Parameters
    ----------
    reading : LidarReading
        Its time is not sent.
    per_metre : int
        Steps of the distance in a metre: 100, or 1000 for a sensor set to millimetres.

    Returns
    -------
    bytes, 9 long
        0x59 0x59, distance, strength, temperature (two bytes each, low byte first), checksum.

    Raises
    ------
    ValueError
        A value that does not fit into its two bytes.

    Examples
    --------
    >>> encode_lidar(LidarReading(0.0, 1.23, 1000, 25.0)).hex(" ")
    '59 59 7b 00 e8 03 c8 08 e8'
    """
    frame = bytearray(FRAME_HEAD)
    counts = {
        "distance": reading.distance * per_metre,
        "strength": reading.strength,
        "temperature": (reading.temperature + 256.0) * 8.0,
    }
    for name, count in counts.items():
        if not 0.0 <= count < 65535.5:
            raise ValueError(f"reading.{name}: {getattr(reading, name)!r} does not fit the frame")
        frame += round(count).to_bytes(2, "little")
    frame.append(sum(frame) & 0xFF)
    return bytes(frame)


def decode_lidar(stream: bytes, *, time: float = 0.0, per_metre: int = 100) -> LidarFrames:
    """The readings in a piece of a TFmini Plus's byte stream, wherever in a frame it begins.

    Parameters
    ----------
    stream : bytes
        What the serial port gave, the last piece's rest in front.
    time : float  [s]
        Written into the readings: when the piece arrived.
    per_metre : int
        As in `encode_lidar`.

    Returns
    -------
    LidarFrames
        A distance that the strength makes worthless is 0.

    Notes
    -----
    Two bytes 0x59 may stand inside a frame as well. Only a matching checksum makes them a head;
    else the search goes on one byte further.

    Examples
    --------
    >>> found = decode_lidar(bytes.fromhex("00 59 59 7b 00 e8 03 c8 08 e8 59"))
    >>> found.readings[0].distance, found.bad, found.rest
    (1.23, 0, b'Y')
    """
    readings, bad, place, done = [], 0, 0, 0
    while (place := stream.find(FRAME_HEAD, place)) >= 0 and place + FRAME_SIZE <= len(stream):
        frame = stream[place : place + FRAME_SIZE]
        if sum(frame[:-1]) & 0xFF != frame[-1]:
            bad, place = bad + 1, place + 1
            continue
        distance, strength, warmth = (
            int.from_bytes(frame[k : k + 2], "little") for k in range(2, 8, 2)
        )
        if strength < WEAKEST or strength == SATURATED:
            distance = 0
        readings.append(LidarReading(time, distance / per_metre, strength, warmth / 8.0 - 256.0))
        done = place = place + FRAME_SIZE
    if place < 0:  # no head is left, but perhaps its first byte
        place = max(done, len(stream) - stream.endswith(FRAME_HEAD[:1]))
    return LidarFrames(readings, bad, stream[place:])

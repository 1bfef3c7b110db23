"""Student number -> seed: numbers of one's own, the same to the bit on every machine.

Draws are made by PCG64 from a hash of the student number and the purpose. The library functions
behind a normal distribution differ in the last bit between processors; the sensors' own rounding,
thousands of times coarser, removes that.
"""

from __future__ import annotations

import hashlib
import re

import numpy as np

Student = int | str  # a student number; some schools have letters in theirs


def student_number(given: object) -> Student:
    """A student number as it was given, checked.

    Raises
    ------
    ValueError
        Neither a whole number nor a short word of letters and digits.
    """
    if isinstance(given, int) and not isinstance(given, bool) and given >= 0:
        return given
    if isinstance(given, str) and re.fullmatch(r"\w{1,40}", given):
        return int(given) if given == "0" or re.fullmatch(r"[1-9][0-9]*", given) else given
    raise ValueError(
        f'student: expected a number such as 21306141022 or "H1D021001", got {given!r}'
    )


def generator(student: Student, *purpose: str) -> np.random.Generator:
    """Random numbers for one student and one purpose.

    Parameters
    ----------
    student : int or str
        Student number; 0 is the course's example student.
    *purpose : str
        What the numbers are for; other words give independent numbers.
    """
    key = "/".join([str(student), *purpose]).encode()
    return np.random.Generator(np.random.PCG64(int.from_bytes(hashlib.sha256(key).digest()[:16])))

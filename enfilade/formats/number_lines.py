"""Lines of numbers in a text, read a block at a time."""

from __future__ import annotations

from typing import BinaryIO, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

F64 = NDArray[np.float64]
Bytes = NDArray[np.uint8]

_BLOCK: Final = 1 << 22
_LONGEST_LINE: Final = 1 << 16
_COMPLETE, _SHORT, _NO_NUMBER = 0, 1, 2
_MOST_DIGITS: Final = 18
_POWERS: Final = 10.0 ** np.arange(23)
_NOT_A_NUMBER: Final = np.frombuffer(b"nanif", np.uint8)


class NumberLines:
    """Reads numbers that blanks, commas or semicolons separate, a line a row.

    Parameters
    ----------
    file
        Opened for bytes, at the first line to read.
    line
        Number of that line, for messages.
    """

    def __init__(self, file: BinaryIO, line: int = 1) -> None:
        self._file = file
        self._block = b""
        self._at = 0
        self._is_last = False
        self.line = line

    def text(self) -> str | None:
        """Return the next line that is not blank, or None at the end."""
        while True:
            end = self._block.find(b"\n", self._at)
            if end < 0 and not self._is_last:
                self._refill()
                continue
            stop = len(self._block) if end < 0 else end
            found = self._block[self._at : stop].decode("utf-8", errors="replace").strip()
            self._at = stop if end < 0 else end + 1
            self.line += 1
            if found:
                return found
            if end < 0:
                return None

    def width(self) -> int:
        """Return how many numbers stand in the next line that is not blank, 0 at the end; nothing is used up."""
        found = self.text()
        if found is None:
            return 0
        self._block, self._at = found.encode() + b"\n" + self._block[self._at :], 0
        self.line -= 1
        return len(found.replace(",", " ").replace(";", " ").split())

    def rows(self, count: int, width: int) -> F64:
        """Return up to `count` rows of the first `width` numbers of a line; fewer at the end of the file.

        Raises
        ------
        ValueError
            A line has too few numbers or something that is none; the message has its number.
        """
        table = np.empty((count, width))
        filled = 0
        while True:
            text = np.frombuffer(self._block, np.uint8)
            rows, self._at, lines, fault = _parse(text, self._at, self._is_last, table, filled, _POWERS, _NOT_A_NUMBER)
            self.line += lines
            filled = rows
            if fault == _SHORT:
                raise ValueError(f"line {self.line} has fewer than {width} numbers")
            if fault == _NO_NUMBER:
                raise ValueError(f"line {self.line} has something that is no number")
            if filled == count or self._is_last:
                return table[:filled]
            self._refill()

    def _refill(self) -> None:
        rest = self._block[self._at :]
        if len(rest) > _LONGEST_LINE + _BLOCK:
            raise ValueError(f"line {self.line} is too long to be one of numbers")
        more = self._file.read(_BLOCK)
        self._block, self._at, self._is_last = rest + more, 0, not more


@njit(cache=True, nogil=True)
def _parse(  # type: ignore[no-untyped-def]
    text, at, is_last, table, filled, powers, not_a_number
):
    """Fill rows of the table; returns how many are filled, where it stopped, the lines it passed and a fault."""
    count, width = table.shape
    size = len(text)
    lines = 0
    while filled < count:
        end = at
        while end < size and text[end] != 10:
            end += 1
        if end == size and not is_last:
            break
        column = 0
        place = at
        while place < end:
            byte = text[place]
            if byte == 32 or byte == 9 or byte == 13 or byte == 44 or byte == 59:
                place += 1
                continue
            if column == width:
                break
            value, after = _number(text, place, end, powers, not_a_number)
            if after < 0:
                return filled, at, lines, 2
            table[filled, column] = value
            column += 1
            place = after
        if 0 < column < width:
            return filled, at, lines, 1
        if column == width:
            filled += 1
        if end == size:
            at = size
            break
        at = end + 1
        lines += 1
    return filled, at, lines, 0


@njit(cache=True, nogil=True)
def _number(text, at, end, powers, not_a_number):  # type: ignore[no-untyped-def]
    """Value of the number that begins at a place, and the place after it, -1 if there is none."""
    negative = text[at] == 45
    if negative or text[at] == 43:
        at += 1
    mantissa, digits, exponent, seen = np.int64(0), 0, 0, False
    after_point = False
    while at < end:
        byte = text[at]
        if 48 <= byte <= 57:
            seen = True
            if digits < _MOST_DIGITS:
                mantissa = mantissa * 10 + np.int64(byte - 48)
                if mantissa > 0:
                    digits += 1
                exponent -= after_point
            else:
                exponent += not after_point
        elif byte == 46 and not after_point:
            after_point = True
        else:
            break
        at += 1
    if not seen:
        letters = 0
        while at < end and (text[at] | 32) in not_a_number:
            at += 1
            letters += 1
        return np.nan, (at if letters == 3 and _ends(text, at, end) else -1)
    if at < end and (text[at] | 32) == 101:
        at += 1
        minus = at < end and text[at] == 45
        if at < end and (minus or text[at] == 43):
            at += 1
        if at == end or not 48 <= text[at] <= 57:
            return 0.0, -1
        power = 0
        while at < end and 48 <= text[at] <= 57:
            power = min(power * 10 + int(text[at]) - 48, 9999)
            at += 1
        exponent += -power if minus else power
    if not _ends(text, at, end):
        return 0.0, -1
    value = _scaled(float(mantissa), exponent, powers)
    return (-value if negative else value), at


@njit(cache=True, nogil=True)
def _scaled(mantissa, exponent, powers):  # type: ignore[no-untyped-def]
    """``mantissa * 10**exponent``, rightly rounded for numbers as people and scanners write them."""
    if mantissa == 0.0:
        return 0.0
    if -len(powers) < exponent < 0:
        return mantissa / powers[-exponent]
    if 0 <= exponent < len(powers):
        return mantissa * powers[exponent]
    return mantissa * 10.0 ** max(min(exponent, 400), -400)


@njit(cache=True, nogil=True)
def _ends(text, at, end):  # type: ignore[no-untyped-def]
    """Whether a number may end here."""
    return at == end or text[at] in (32, 9, 13, 44, 59)

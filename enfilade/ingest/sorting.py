"""Long arrays of whole numbers sorted by their digits, on all processors."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.parallel import at_once, in_slices, slices

I64 = NDArray[np.int64]

_DIGIT_BITS: Final = 11
"""So many bits of a number are looked at in one pass: the places of 2048 digits stay in the nearest memory."""
_LONG: Final = 1 << 17
"""Shorter arrays NumPy sorts as fast."""


def sort_above(numbers: I64, low_bit: int, bits: int) -> I64:
    """Sort ``(n,)`` numbers that are not negative by their bits from `low_bit` on, of which there are `bits`.

    Numbers that agree there must come in increasing order, as an index in the bits below makes them: then all is
    sorted. The array may be sorted in place or be used up.
    """
    if len(numbers) < _LONG:
        numbers.sort()
        return numbers
    passes = -(-bits // _DIGIT_BITS)
    digit_bits = -(-bits // passes) if passes else 0
    source, target = numbers, np.empty_like(numbers)
    for k in range(passes):
        _sort_by_digit(source, target, low_bit + k * digit_bits, (1 << digit_bits) - 1)
        source, target = target, source
    return source


def _sort_by_digit(source: I64, target: I64, shift: int, mask: int) -> None:
    """Put numbers in order of one digit, those that agree in their old order."""
    counts = np.array(in_slices(_count_digits, len(source), source, shift, mask))
    by_digit = counts.T.ravel()
    places = np.ascontiguousarray((np.cumsum(by_digit) - by_digit).reshape(counts.T.shape).T)
    at_once(
        _scatter,
        ((*part, source, target, shift, mask, own) for part, own in zip(slices(len(source)), places, strict=True)),
    )


@njit(cache=True, nogil=True)
def _count_digits(first: int, past: int, source: I64, shift: int, mask: int) -> I64:
    counts = np.zeros(mask + 1, np.int64)
    for i in range(first, past):
        counts[(source[i] >> shift) & mask] += 1
    return counts


@njit(cache=True, nogil=True)
def _scatter(first: int, past: int, source: I64, target: I64, shift: int, mask: int, places: I64) -> None:
    """Put numbers `first` to `past` where the next of their digit belongs."""
    for i in range(first, past):
        digit = (source[i] >> shift) & mask
        target[places[digit]] = source[i]
        places[digit] += 1

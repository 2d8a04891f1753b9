"""Quasi-random normal draws: Sobol points (Joe & Kuo 2008), scrambled (Matousek 1998), made normal."""

from functools import lru_cache

import numpy as np

Array = np.ndarray

BITS = 30
POLYNOMIALS = ((0, 0, ()), (1, 0, (1,)), (2, 1, (1, 3)), (3, 1, (1, 3, 1)))
"""By dimension: degree and inner coefficients of its primitive polynomial, first direction numbers."""


@lru_cache(maxsize=8)
def normal_draws(samples: int) -> Array:
    """Quasi-random standard normal draws `(samples, 4)`, the same at every call."""
    from scipy.special import ndtri

    z = ndtri(np.clip(scrambled_sobol(samples), 1e-9, 1 - 1e-9))
    # Exact first two moments: certain pushes keep their mean, linear errors their spread.
    z = (z - z.mean(axis=0)) / z.std(axis=0)
    z.flags.writeable = False
    return z


def scrambled_sobol(samples: int) -> Array:
    """The first points `(samples, 4)` of one scrambled sequence in the unit cube.

    These are the draws of torch's `SobolEngine(4, scramble=True, seed=0)` to the last bit (a test compares
    them), made here because importing torch would cost every run seconds, and scipy.stats one.
    """
    # Not a generator of today: its stream is the one that torch's scrambling comes from.
    twister = np.random.RandomState(0)
    dimensions = len(POLYNOMIALS)

    def coins(*shape: int) -> Array:
        return twister.randint(0, 2**32, shape, dtype=np.uint32).astype(np.int64) & 1

    powers = 1 << np.arange(BITS)
    shift = coins(dimensions, BITS) @ powers
    mixing = np.tril(coins(dimensions, BITS, BITS), -1) + np.eye(BITS, dtype=np.int64)
    # Bits of the direction numbers, the highest first, are mixed over GF(2).
    bits = (directions()[:, None] >> np.arange(BITS)[::-1, None]) & 1
    mixed = powers[::-1] @ (mixing @ bits % 2)
    points = np.empty((samples, dimensions), dtype=np.int64)
    points[:1] = shift
    for n in range(1, samples):
        changed = (n & -n).bit_length() - 1  # the bit of the Gray code that changes
        points[n] = points[n - 1] ^ mixed[:, changed]
    unit = points / 2.0**BITS
    unit[:1] = unit[:1].astype(np.float32)  # as torch has the first point
    return unit


def directions() -> Array:
    """Direction numbers `(4, BITS)` as integers of BITS bits, by the recurrence of Bratley & Fox (1988)."""
    numbers = np.empty((len(POLYNOMIALS), BITS), dtype=np.int64)
    for row, (degree, inner, first) in zip(numbers, POLYNOMIALS, strict=True):
        m = [*first] or [1] * BITS
        for i in range(len(m), BITS):
            new = m[i - degree] ^ (m[i - degree] << degree)
            for k in range(1, degree):
                new ^= ((inner >> (degree - 1 - k)) & 1) * (m[i - k] << k)
            m.append(new)
        row[:] = [value << (BITS - 1 - i) for i, value in enumerate(m)]
    return numbers

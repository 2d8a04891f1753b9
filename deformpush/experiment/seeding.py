"""Named random generators that all descend from one seed."""

import zlib

import numpy as np


def generator(seed: int, name: str) -> np.random.Generator:
    """Return the generator called `name` of the run with this `seed`.

    Streams of different names are independent, so a part that starts to draw numbers changes no other part.
    """
    return np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode())]))

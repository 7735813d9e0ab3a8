"""Run what draws from torch's global generator from a stream of one's own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pyro
import torch

__all__ = ["seeded_torch"]


@contextmanager
def seeded_torch(rng: np.random.Generator) -> Iterator[None]:
    """Seed torch's and Pyro's global generators from `rng` and use one thread; restore both.

    The tables of one step are too small to share out: more threads would only wait for each
    other, and one thread adds numbers in one order wherever it runs.
    """
    before, threads = pyro.util.get_rng_state(), torch.get_num_threads()
    pyro.set_rng_seed(int(rng.integers(2**31)))
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
        pyro.util.set_rng_state(before)

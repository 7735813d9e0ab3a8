"""Derive named, independent random streams, so that a trial is the same alone or among many."""

from __future__ import annotations

import hashlib
import random

import numpy as np

__all__ = ["child", "scalar_rng"]


def child(rng: np.random.Generator, *names: str | int) -> np.random.Generator:
    """Return the stream of `rng` that is called `names`, without drawing from `rng`.

    Parameters
    ----------
    rng
        The parent stream, made by ``numpy.random.default_rng(seed)`` or by this function.
    *names
        What the stream is for, such as ``("trial", 17, "environment")``.

    Returns
    -------
    numpy.random.Generator
        The same stream for the same parent seed and names, on any machine and in any process.

    Examples
    --------
    >>> import numpy as np
    >>> first = child(np.random.default_rng(0), "start").integers(1000)
    >>> first == child(np.random.default_rng(0), "start").integers(1000)
    np.True_
    """
    parent = rng.bit_generator.seed_seq
    if not isinstance(parent, np.random.SeedSequence):
        raise TypeError(
            "rng was not made from a SeedSequence; make it with numpy default_rng(seed)"
        )
    digest = hashlib.sha256("\x1f".join(str(n) for n in names).encode()).digest()
    key = tuple(int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4))
    seed = np.random.SeedSequence(parent.entropy, spawn_key=(*parent.spawn_key, *key))
    return np.random.default_rng(seed)


def scalar_rng(rng: np.random.Generator) -> random.Random:
    """Return a stdlib generator of the same stream: its scalar draws are ten times cheaper."""
    return random.Random(int(rng.integers(2**63)))

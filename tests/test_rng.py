"""Named streams: the same for the same name, and independent of what else is drawn."""

import os
import subprocess
import sys

import numpy as np
import pytest

from sloop_ppl.rng import child


def draws(rng):
    return rng.integers(0, 2**32, size=8).tolist()


def test_the_same_name_is_the_same_stream():
    assert draws(child(np.random.default_rng(3), "trial", 17)) == draws(
        child(np.random.default_rng(3), "trial", 17)
    )


def test_deriving_draws_nothing_and_drawing_changes_nothing():
    parent, untouched = np.random.default_rng(3), np.random.default_rng(3)
    before = draws(child(parent, "a"))
    assert draws(parent) == draws(untouched)
    assert draws(child(parent, "a")) == before


def test_names_seeds_and_parents_make_different_streams():
    root = np.random.default_rng(3)
    streams = [
        root,
        child(root, "a"),
        child(root, "b"),
        child(root, "a", "b"),
        child(root, "ab"),
        child(root, "a", 1),
        child(root, "a", 2),
        child(child(root, "b"), "a"),
        child(np.random.default_rng(4), "a"),
    ]
    assert len({tuple(draws(s)) for s in streams}) == len(streams)


def test_a_stream_does_not_depend_on_the_hash_seed():
    code = (
        "import numpy as np; from sloop_ppl.rng import child;"
        "print(child(np.random.default_rng(0), 'start', 5).integers(0, 2**32, 4).tolist())"
    )
    told = {
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("0", "1", "12345")
    }
    assert len(told) == 1


def test_a_generator_without_a_seed_sequence_is_refused():
    class Bits:
        seed_seq = None

    class Generator:
        bit_generator = Bits()

    with pytest.raises(TypeError, match=r"make it with numpy default_rng\(seed\)"):
        child(Generator(), "a")

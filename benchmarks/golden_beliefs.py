"""Record what every model believes, or check that no belief has moved since.

Run: python benchmarks/golden_beliefs.py record FILE.npz [--descriptions DIR]
     python benchmarks/golden_beliefs.py check FILE.npz [--descriptions DIR] [--tolerance 1e-9]
     python benchmarks/golden_beliefs.py --quick    (two examples, recorded and checked)

For who changes how beliefs are reckoned and not what they are: record before, check after. The
models are the seven presets, the `paper` variants of the three that have one, and `bayes` with
fronts that face the nearest street; each is told the gold relations of the bundled examples and,
with `--descriptions`, of the .jsonl files in a folder. Beliefs are kept whole, as float64: some
29 MB for 192 targets. `check` prints the largest total variation of each model, and fails when it
is above the tolerance or when the file holds other beliefs than those it is asked about.

Record and check on one machine. The network that predicts fronts for `bayes` works in float32:
another processor, or predicting the fronts of other landmarks along with one, moves its beliefs by
up to some 1e-7.

`record --sketch` writes a few numbers of each belief instead: tests/parity/golden_beliefs.npz,
which tests/parity/test_goldens.py checks.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.special import entr

from sloop_ppl.eval import AnnotatedDescription, bundled_examples, read_descriptions
from sloop_ppl.eval.quality import beliefs_of, read_annotated
from sloop_ppl.maps import load_map
from sloop_ppl.models import FRAME_PREDICTORS, ObservationModel, preset

PUBLISHED = ("uniform", "keyword", "informed", "sloop", "sloop-m2", "sloop-m4", "bayes")
PAPER = ("sloop", "sloop-m2", "sloop-m4")
NEAREST = "bayes (nearest street)"
PROJECTIONS = 24

Table = NDArray[np.float64]


def main() -> None:
    """Do what is asked."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("what", nargs="?", choices=["record", "check"])
    options.add_argument("file", nargs="?", type=Path, help="where the beliefs are kept, .npz")
    options.add_argument("--quick", action="store_true", help="record and check two examples")
    options.add_argument("--descriptions", type=Path, help="folder of description files, .jsonl")
    options.add_argument("--tolerance", type=float, default=1e-9, help="largest total variation")
    options.add_argument("--sketch", action="store_true", help="record a few numbers of each")
    given = options.parse_args()
    torch.set_num_threads(1)
    descriptions = bundled_examples()
    if given.quick:
        with TemporaryDirectory() as folder:
            file = Path(folder) / "goldens.npz"
            np.savez(file, **everything(descriptions[:2]))
            raise SystemExit(not check(file, descriptions[:2], given.tolerance))
    if given.what is None or given.file is None:
        options.error("tell what to do, record or check, and the file")
    if given.descriptions:
        descriptions += read_descriptions(sorted(given.descriptions.glob("*.jsonl")))
    if given.what == "check":
        raise SystemExit(not check(given.file, descriptions, given.tolerance))
    if given.sketch:
        np.savez_compressed(given.file, **sketches(descriptions))
    else:
        np.savez(given.file, **everything(descriptions))


def models() -> dict[str, ObservationModel]:
    """Return the models by name."""
    published = {name: preset(name) for name in PUBLISHED}
    paper = {f"{name} (paper)": preset(name, "paper") for name in PAPER}
    learnt: Any = published["bayes"].frame_prior
    prior = replace(learnt, predictor=FRAME_PREDICTORS["nearest-street"])
    nearest = replace(published["bayes"], frame_prior=prior)
    return published | paper | {NEAREST: nearest}


def beliefs(
    descriptions: Sequence[AnnotatedDescription], model: ObservationModel
) -> dict[str, Table]:
    """Return "scene, target" -> belief given the gold relations, shape (H, W)."""
    found = {}
    for annotated in descriptions:
        city, said = read_annotated(annotated, load_map(annotated.map), "gold")
        for target, belief in beliefs_of(annotated, said, city, model).items():
            found[f"{annotated.id}, {target}"] = belief
    return found


def everything(descriptions: Sequence[AnnotatedDescription]) -> dict[str, Table]:
    """Return "model, scene, target" -> belief."""
    return {
        f"{name}, {which}": belief
        for name, model in models().items()
        for which, belief in beliefs(descriptions, model).items()
    }


def check(file: Path, descriptions: Sequence[AnnotatedDescription], tolerance: float) -> bool:
    """Print how far each model's beliefs are from those of a file; tell whether all is well."""
    found = everything(descriptions)
    with np.load(file) as opened:
        kept = {which: opened[which] for which in opened.files}
    sound = True
    for name in models():
        apart = {
            which: 0.5 * float(np.abs(belief - kept[which]).sum())
            for which, belief in found.items()
            if which.startswith(f"{name}, ") and which in kept
        }
        largest = float(np.max([*apart.values(), 0.0]))  # NaN when one is
        moved = [which for which, distance in apart.items() if not distance <= tolerance]
        sound &= not moved
        shift = f"; {len(moved)} moved, the first that of {moved[0]}" if moved else ""
        print(f"{name}: total variation at most {largest:.1e} over {len(apart)} beliefs{shift}")
    lacking, unasked = len(found.keys() - kept.keys()), len(kept.keys() - found.keys())
    if lacking or unasked:
        print(f"{lacking} beliefs are not in {file}; {unasked} of its beliefs are not asked about")
    return sound and not lacking and not unasked


def sketches(descriptions: Sequence[AnnotatedDescription]) -> dict[str, NDArray[np.generic]]:
    """Return a few numbers of each belief, by model M and belief B.

    Returns
    -------
    dict
        ``models``, shape (M,), and ``beliefs``, shape (B,): their names; ``signs``: the bits of
        the projections, shape (P, S / 8); ``projections``, shape (M, B, P), and ``entropies``,
        shape (M, B).
    """
    found = {name: beliefs(descriptions, model) for name, model in models().items()}
    flat = np.stack(
        [[belief.reshape(-1) for belief in tables.values()] for tables in found.values()]
    )
    bits = np.random.default_rng(0).integers(2, size=(PROJECTIONS, flat.shape[-1]), dtype=np.uint8)
    packed = np.packbits(bits, axis=1)
    projections, entropies = sketch(flat, packed)
    return {
        "models": np.array(list(found)),
        "beliefs": np.array(list(found[PUBLISHED[0]])),
        "signs": packed,
        "projections": projections,
        "entropies": entropies,
    }


def sketch(flat: Table, signs: NDArray[np.uint8]) -> tuple[Table, Table]:
    """Return the projections, shape (..., P), and entropies of beliefs of shape (..., S)."""
    bits = np.unpackbits(signs, axis=1, count=flat.shape[-1])
    projections: Table = flat @ (2.0 * bits - 1.0).T
    return projections, entr(flat).sum(-1)


if __name__ == "__main__":
    main()

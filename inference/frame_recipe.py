"""Train a frame network on the maps of a folder and say how it was made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from sloop_ppl.inference.frame_examples import FrameExamples, frame_examples, joined
from sloop_ppl.inference.frame_labels import address_labels
from sloop_ppl.inference.frame_training import RECIPES, Recipe, TrainingInfo, train_frames
from sloop_ppl.maps import CityMap
from sloop_ppl.models.frames import TrainedFrames
from sloop_ppl.rng import child

__all__ = ["examples_of_maps", "train_on_maps", "training_command", "with_limits"]


def examples_of_maps(
    maps: Mapping[str, CityMap],
    view: str,
    *,
    rng: np.random.Generator,
    progress: Callable[[str], None] | None = None,
) -> dict[str, FrameExamples]:
    """Return the examples of each map that has labels, by the map's name."""
    found = {}
    for name, city in maps.items():
        labels = address_labels(city)
        if labels:
            found[name] = frame_examples(city, labels, view, rng=rng)
        if progress:
            progress(f"{name}: {len(labels)} labelled buildings")
    return found


def train_on_maps(
    maps: Mapping[str, CityMap],
    recipe: str,
    *,
    epochs: int | None = None,
    patience: int | None = None,
    command: str = "",
    rng: np.random.Generator,
    progress: Callable[[str], None] | None = None,
) -> tuple[TrainedFrames, TrainingInfo]:
    """Train on the buildings of some maps whose address tells their front.

    Parameters
    ----------
    maps : name -> map.
    recipe : name in :data:`sloop_ppl.inference.frame_training.RECIPES`.
    epochs, patience : instead of the recipe's.
    command : the command that does just this, to be kept with the weights.
    rng : draws all that is drawn.
    progress : told how it goes, a line at a time.

    Raises
    ------
    UnknownName : for another recipe.
    InputError : when there are too few labelled buildings, or training fails.
    """
    chosen = with_limits(RECIPES[recipe], epochs, patience)
    sets = examples_of_maps(maps, chosen.shape.view, rng=child(rng, "examples"), progress=progress)
    network, info = train_frames(
        joined(list(sets.values())), chosen, rng=child(rng, "training"), progress=progress
    )
    about = {
        "name": recipe,
        "trained_on": ", ".join(f"{name} ({len(some)})" for name, some in sets.items()),
        "labels": "addr:street: the nearest point of the named street from the centroid",
        "data": "(c) OpenStreetMap contributors, ODbL 1.0",
        "passes": str(info.epochs),
        "loss_on_held_back": f"{info.best:.4f}",
        "command": command,
    }
    return TrainedFrames(network, MappingProxyType(about)), info


def with_limits(recipe: Recipe, epochs: int | None, patience: int | None) -> Recipe:
    """Return a recipe with other limits, where they are given."""
    return replace(
        recipe,
        epochs=recipe.epochs if epochs is None else epochs,
        patience=recipe.patience if patience is None else patience,
    )


def training_command(
    recipe: str, leave_out: str, epochs: int | None, patience: int | None, seed: int
) -> str:
    """Return the command line that trains so; DIR is the folder of maps."""
    told: dict[str, str | int | None] = {"--recipe": recipe, "--leave-out": leave_out or None}
    told |= {"--epochs": epochs, "--patience": patience, "--seed": seed}
    options = " ".join(f"{name} {value}" for name, value in told.items() if value is not None)
    return f"sloop frames train --maps DIR {options} --out {recipe}.safetensors"

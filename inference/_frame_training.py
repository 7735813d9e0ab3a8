"""Train networks to tell which way buildings face, by recipes, and say how they were made."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference._enumeration import seeded_torch
from sloop_ppl.inference._frame_examples import (
    Batch,
    FrameExamples,
    FrameLabel,
    examples_of_maps,
    joined,
)
from sloop_ppl.maps import CityMap
from sloop_ppl.models.frames import FrameNetwork, NetworkShape, Outputs, TrainedFrames, log_density
from sloop_ppl.registry import Registry
from sloop_ppl.rng import child

__all__ = [
    "RECIPES",
    "Recipe",
    "TrainingInfo",
    "squared_angle",
    "train_frames",
    "train_on_maps",
    "training_command",
    "with_limits",
]

_CHECKED = 1 / 8  # share of the buildings held back, to stop by
_TURNS_CHECKED = 4  # each is checked in so many turns, drawn once, so that passes compare


@dataclass(frozen=True)
class Recipe:
    """How a network is made and trained.

    Parameters
    ----------
    shape
        What it is made of.
    loss
        ``"circular-log"``, less the log density of the label; or ``"squared-angle"``, the paper's
        squared angular difference to one predicted angle.
    learning_rate, weight_decay
        Learning rate and weight decay of Adam, with decoupled decay.
    batch
        Buildings a step.
    epochs
        At most so many passes.
    patience
        Passes without a better score on the buildings held back before it stops.
    """

    shape: NetworkShape = field(default_factory=NetworkShape)
    loss: Literal["circular-log", "squared-angle"] = "circular-log"
    learning_rate: float = 2e-3
    weight_decay: float = 1e-2
    batch: int = 64
    epochs: int = 60
    patience: int = 20


RECIPES: Registry[Recipe] = Registry("recipe")
"""Recipes by name: ours for each view, and the paper's."""
RECIPES.add("ego-ctx", Recipe())
RECIPES.add("ctx", Recipe(NetworkShape(view="ctx", streets=False)))
RECIPES.add("ego", Recipe(NetworkShape(view="ego", streets=False)))
RECIPES.add(
    "paper",
    Recipe(
        NetworkShape(streets=False, angle=True, greys=True),
        loss="squared-angle",
        learning_rate=1e-5,
        weight_decay=0.0,
        batch=16,
        epochs=300,
    ),
)


@dataclass(frozen=True)
class TrainingInfo:
    """How a training went.

    Parameters
    ----------
    epochs
        Passes that were made.
    examples, held_back
        Numbers of buildings.
    losses
        Loss on the buildings held back after each pass.
    best
        The least of these, that of the network returned.
    """

    epochs: int
    examples: int
    held_back: int
    losses: tuple[float, ...]
    best: float


def train_frames(
    examples: FrameExamples,
    recipe: Recipe,
    *,
    rng: np.random.Generator,
    progress: Callable[[str], None] | None = None,
) -> tuple[FrameNetwork, TrainingInfo]:
    """Train a network until the buildings held back are told no better.

    Parameters
    ----------
    examples
        Labelled buildings; one in eight is held back, which needs at least 16.
    rng
        Draws initial weights, batches, turns and who is held back.
    progress
        Called with a line per pass.

    Returns
    -------
    tuple of FrameNetwork and TrainingInfo
        The network that was best on the buildings held back.

    Raises
    ------
    InputError
        When there are too few examples, or the loss is no finite number.

    Notes
    -----
    Source of the recipe ``"paper"``: SLOOP sec. IV-C and V (Adam, 1e-5, patience 20, squared
    angular loss, one network for front and behind: behind is front turned round). Buildings are
    turned by any angle, mirrored and shifted in each pass. The paper's single angle gets the
    concentration and lapse that suit its errors on the buildings held back.
    """
    if len(examples) < 16:
        raise InputError(
            f"There are {len(examples)} labelled buildings to train on; expected at least 16"
        )
    with torch.enable_grad(), seeded_torch(rng):
        generator = torch.Generator().manual_seed(int(rng.integers(2**31)))
        order = torch.randperm(len(examples), generator=generator)
        count = max(4, round(len(examples) * _CHECKED))
        held, rest = order[:count], order[count:]
        checks = [examples.batch(held, generator) for _ in range(_TURNS_CHECKED)]
        network = FrameNetwork(recipe.shape)
        learnt = [p for p in network.parameters() if p.requires_grad]
        optimiser = torch.optim.AdamW(
            learnt, lr=recipe.learning_rate, weight_decay=recipe.weight_decay
        )
        losses: list[float] = []
        best, waited = math.inf, 0
        kept = {name: t.clone() for name, t in network.state_dict().items()}
        while len(losses) < recipe.epochs and waited < recipe.patience:
            network.train()
            shuffled = rest[torch.randperm(len(rest), generator=generator)]
            for some in shuffled.split(recipe.batch):
                optimiser.zero_grad()
                loss = _loss(network, examples.batch(some, generator), recipe)
                _check(loss, len(losses) + 1)
                loss.backward()
                optimiser.step()
            network.eval()
            with torch.no_grad():
                now = float(torch.stack([_loss(network, b, recipe) for b in checks]).mean())
            losses.append(now)
            _check(torch.tensor(now), len(losses))
            waited += 1
            if now < best - 1e-4:
                best, waited = now, 0
                kept = {name: t.clone() for name, t in network.state_dict().items()}
            if progress:
                progress(f"pass {len(losses)}: loss {now:.4f} on {count} buildings held back")
        network.load_state_dict(kept)
        network.eval()
        if recipe.shape.angle:
            _suit_errors(network, checks)
    return network, TrainingInfo(len(losses), len(rest), count, tuple(losses), best)


def squared_angle(outputs: Outputs, frame_angle_rad: Tensor) -> Tensor:
    """Return the squared difference between the first part's mean and the label, radians^2."""
    difference = outputs.mean_rad[:, 0] - frame_angle_rad
    return torch.atan2(torch.sin(difference), torch.cos(difference)).square()


def train_on_maps(
    maps: Mapping[str, CityMap],
    recipe: str,
    *,
    epochs: int | None = None,
    patience: int | None = None,
    command: str = "",
    annotated: Mapping[str, Sequence[FrameLabel]] = MappingProxyType({}),
    rng: np.random.Generator,
    progress: Callable[[str], None] | None = None,
) -> tuple[TrainedFrames, TrainingInfo]:
    """Train on the buildings of some maps whose address tells their front.

    Parameters
    ----------
    maps
        Name -> map.
    recipe
        Name in :data:`sloop_ppl.inference._frame_training.RECIPES`.
    epochs, patience
        Epochs and patience instead of the recipe's.
    command
        The command that does just this, to be kept with the weights.
    annotated
        Fronts that people gave, in place of those that addresses tell, by the map's name.
    progress
        Called with a line at a time on how it goes.

    Raises
    ------
    UnknownName
        For another recipe.
    InputError
        When there are too few labelled buildings, or training fails.
    """
    chosen = with_limits(RECIPES[recipe], epochs, patience)
    sets = examples_of_maps(
        maps, chosen.shape.view, rng=child(rng, "examples"), progress=progress, annotated=annotated
    )
    network, info = train_frames(
        joined(list(sets.values())), chosen, rng=child(rng, "training"), progress=progress
    )
    about = {
        "name": recipe,
        "trained_on": ", ".join(f"{name} ({len(some)})" for name, some in sets.items()),
        "labels": _labels_in_words(maps, annotated),
        "data": "(c) OpenStreetMap contributors, ODbL 1.0",
        "passes": str(info.epochs),
        "loss_on_held_back": f"{info.best:.4f}",
        "command": command,
    }
    return TrainedFrames(network, MappingProxyType(about)), info


def _labels_in_words(maps: Mapping[str, CityMap], annotated: Collection[str]) -> str:
    by_address = "addr:street: the nearest point of the named street from the centroid"
    if not annotated:
        return by_address
    people = "annotators: the mean of the fronts they drew"
    return people if set(maps) <= set(annotated) else f"{by_address}; {people}"


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
    values: dict[str, str | int | None] = {"--recipe": recipe, "--leave-out": leave_out or None}
    values |= {"--epochs": epochs, "--patience": patience, "--seed": seed}
    options = " ".join(f"{name} {value}" for name, value in values.items() if value is not None)
    return f"sloop frames train --maps DIR {options} --out {recipe}.safetensors"


def _loss(network: FrameNetwork, batch: Batch, recipe: Recipe) -> Tensor:
    outputs = network(batch.pictures, batch.bearing_rad, batch.features, batch.there)
    if recipe.loss == "squared-angle":
        return squared_angle(outputs, batch.frame_angle_rad).mean()
    return -log_density(outputs, batch.frame_angle_rad).mean()


def _check(loss: Tensor, epoch: int) -> None:
    if not bool(torch.isfinite(loss)):
        raise InputError(
            f"The loss is {float(loss.detach())} in pass {epoch}; expected a finite number: lower "
            "the learning rate, and look for NaN in the maps"
        )


def _suit_errors(network: FrameNetwork, checks: list[Batch]) -> None:
    """Give a network of one angle the concentration and lapse that suit its errors best."""
    with torch.no_grad():
        outputs = [network(b.pictures, b.bearing_rad, b.features, b.there) for b in checks]
        error = torch.cat(
            [o.mean_rad[:, 0] - b.frame_angle_rad for o, b in zip(outputs, checks, strict=True)]
        )
        best = -math.inf
        for kappa in np.geomspace(0.5, 500, 25):
            for lapse in np.linspace(0.02, 0.9, 23):
                found = _score(error, float(kappa), float(lapse))
                if found > best:
                    best = found
                    network.log_kappa[0] = math.log(kappa)
                    network.angle_lapse.fill_(math.log(lapse / (1 - lapse)))


def _score(error: Tensor, kappa: float, lapse: float) -> float:
    """Return the mean log density of errors, radians, under a von Mises and a lapse."""
    scaled = float(torch.special.i0e(torch.tensor(kappa)))
    density = torch.exp(kappa * (torch.cos(error) - 1)) / scaled
    return float(torch.log((1 - lapse) * density + lapse).mean())

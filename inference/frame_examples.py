"""Turn labelled buildings into what a frame network learns from, turned and shifted at random."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference.frame_labels import FrameLabel
from sloop_ppl.maps import CityMap
from sloop_ppl.models.frames import VIEWS, choices_of, padded_choices, pictures_of
from sloop_ppl.rng import child

__all__ = ["Batch", "FrameExamples", "frame_examples", "joined"]

_SHIFT_M = 3.0
_CTX_REACH = 0.45  # how far from a tile's middle a landmark is put, in sides of the tile


@dataclass(frozen=True, eq=False)
class Batch:
    """What a network takes, and the fronts it should tell.

    Shape legend: N buildings, C streets, F features.
    """

    pictures: Tensor
    bearing_rad: Tensor
    features: Tensor
    there: Tensor
    front_rad: Tensor


@dataclass(frozen=True, eq=False)
class FrameExamples:
    """Labelled buildings, each drawn several times, turned and shifted.

    Shape legend: N buildings, R drawings of each, C streets, F features.

    Parameters
    ----------
    pictures : planes as uint8, 255 for whole, shape (N, R, 4, 28, 28).
    turns_rad : by how much the scene of each drawing is turned, shape (N, R).
    bearing_rad, features, there : streets around each, shape (N, C), (N, C, F), (N, C).
    front_rad : the label, shape (N,).
    """

    pictures: Tensor
    turns_rad: Tensor
    bearing_rad: Tensor
    features: Tensor
    there: Tensor
    front_rad: Tensor

    def __len__(self) -> int:
        return len(self.front_rad)

    def batch(self, which: Tensor, generator: torch.Generator) -> Batch:
        """Return some examples, each in a drawing, a quarter turn and a mirroring of its own."""
        n, draws = len(which), self.pictures.shape[1]
        drawing = torch.randint(draws, (n,), generator=generator)
        quarter = torch.randint(4, (n,), generator=generator)
        mirrored = torch.randint(2, (n,), generator=generator).bool()
        pictures = self.pictures[which, drawing].float() / 255
        for turn in range(1, 4):
            some = quarter == turn
            pictures[some] = torch.rot90(pictures[some], -turn, (-2, -1))
        pictures[mirrored] = pictures[mirrored].flip(-2)
        angle = self.turns_rad[which, drawing] + quarter * (math.pi / 2)
        bearing = self.bearing_rad[which] + angle[:, None]
        front = self.front_rad[which] + angle
        return Batch(
            pictures,
            torch.where(mirrored[:, None], -bearing, bearing),
            self.features[which],
            self.there[which],
            torch.where(mirrored, -front, front),
        )


def frame_examples(
    city: CityMap,
    labels: Sequence[FrameLabel],
    view: str = "ego-ctx",
    *,
    drawings: int = 6,
    rng: np.random.Generator,
) -> FrameExamples:
    """Return the examples of one map.

    Parameters
    ----------
    city : the map.
    labels : buildings and their fronts.
    view : the picture to draw; see :data:`sloop_ppl.models.frames.VIEWS`.
    drawings : how often each building is drawn, > 0; turned by any angle, shifted by a few
        metres, a picture that is not centred by up to half its side.
    rng : draws turns and shifts, a stream for each building.

    Raises
    ------
    InputError : when a label is no finite angle.
    """
    for label in labels:
        if not math.isfinite(label.front_rad):
            raise InputError(
                f"The front of '{label.building}' on map '{city.name}' is {label.front_rad}; "
                "expected a finite number of radians"
            )
    pictures, turns = [], []
    for label in labels:
        own = child(rng, city.name, label.building)
        angles = own.uniform(0, math.pi / 2, drawings)
        shifts = [_shift(city, label.building, view, angle, own) for angle in angles]
        same = [label.building] * drawings
        drawn = pictures_of(city, same, view, turns_rad=angles, shifts_m=shifts)
        pictures.append((drawn * 255).astype(np.uint8))
        turns.append(angles)
    choices = choices_of(city, [label.building for label in labels])
    bearing, features, there = padded_choices(choices)
    return FrameExamples(
        torch.from_numpy(np.stack(pictures)),
        torch.from_numpy(np.array(turns, dtype=np.float32)),
        torch.from_numpy(bearing),
        torch.from_numpy(features),
        torch.from_numpy(there),
        torch.tensor([label.front_rad for label in labels], dtype=torch.float32),
    )


def joined(sets: Sequence[FrameExamples]) -> FrameExamples:
    """Return the examples of several maps as one.

    Raises
    ------
    InputError : when there is none.
    """
    some = [examples for examples in sets if len(examples)]
    if not some:
        raise InputError(
            "No building tells which way it faces; expected some with 'addr:street' and a street "
            "of that name on the map"
        )
    most = max(examples.bearing_rad.shape[1] for examples in some)
    return FrameExamples(
        torch.cat([e.pictures for e in some]),
        torch.cat([e.turns_rad for e in some]),
        torch.cat([_widened(e.bearing_rad, most) for e in some]),
        torch.cat([_widened(e.features, most) for e in some]),
        torch.cat([_widened(e.there, most) for e in some]),
        torch.cat([e.front_rad for e in some]),
    )


def _widened(table: Tensor, columns: int) -> Tensor:
    more = table.new_zeros((len(table), columns - table.shape[1], *table.shape[2:]))
    return torch.cat([table, more], 1)


def _shift(
    city: CityMap, building: str, view: str, turn_rad: float, rng: np.random.Generator
) -> tuple[float, float]:
    """Return by how much the middle of the picture is moved, metres."""
    chosen = VIEWS[view]
    if chosen.centred:
        east, north = rng.normal(0, _SHIFT_M, 2)
        return float(east), float(north)
    reach = chosen.side_m * _CTX_REACH * math.sqrt(rng.uniform())
    angle = rng.uniform(0, 2 * math.pi) - turn_rad
    x, y = city.centroid(building)
    grid, side = city.grid, chosen.side_m
    from_west, from_north = (x - grid.west_m) % side, (grid.north_m - y) % side
    off_x, off_y = from_west - side / 2, side / 2 - from_north
    return off_x - reach * math.cos(angle), off_y - reach * math.sin(angle)

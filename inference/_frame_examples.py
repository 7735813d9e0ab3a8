"""What a frame network learns from: buildings of maps whose front is known, drawn at random."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
import shapely
import torch
from torch import Tensor

from sloop_ppl._foreign import is_folder
from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.maps.osm import import_osm
from sloop_ppl.models.frames import VIEWS, choices_of, padded_choices, pictures_of
from sloop_ppl.rng import child

__all__ = [
    "Batch",
    "FrameExamples",
    "FrameLabel",
    "address_labels",
    "entrance_labels",
    "examples_of_maps",
    "frame_examples",
    "joined",
    "maps_of_folder",
]

_SHIFT_M = 3.0  # how far a picture's middle is drawn off: a footprint's centroid is no surer
_CTX_REACH = 0.45  # how far from a tile's middle a landmark is put, in sides of the tile
_WITHIN_M = 60.0  # from the wall to the street of its address


def maps_of_folder(
    folder: str | Path,
    *,
    leave_out: tuple[str, ...] = (),
    progress: Callable[[str], None] | None = None,
) -> dict[str, CityMap]:
    """Return the maps of a folder by the name of their file up to its first dot.

    Parameters
    ----------
    folder
        Holds ``.osm``, ``.osm.pbf`` or ``.geojson`` files.
    leave_out
        Names not to read.
    progress
        Called with a line per map.

    Raises
    ------
    InputError
        When there is no such folder, no map in it, or two of one name, or a name to leave out is
        not there.
    MapError
        When a file is no map.
    """
    place = Path(folder)
    if not is_folder(place):
        raise InputError(f"The maps folder '{folder}' is no folder; expected one of map files")
    endings = (".geojson", ".osm", ".osm.pbf")
    paths = [p for p in sorted(place.iterdir()) if p.name.endswith(endings)]
    names = [path.name.split(".")[0] for path in paths]
    if not paths:
        raise InputError(
            f"The maps folder '{folder}' holds no map; expected .osm, .osm.pbf or .geojson files"
        )
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise InputError(f"The maps folder '{folder}' holds '{min(twice)}' twice; keep one")
    for name in leave_out:
        if name not in names:
            raise InputError(
                f"Map '{name}' to leave out is not in folder '{folder}'; it holds "
                f"{', '.join(names)}"
            )
    maps = {}
    for name, path in zip(names, paths, strict=True):
        if name in leave_out:
            continue
        if path.suffix == ".geojson":
            maps[name] = load_map(path)
        else:
            maps[name], _ = import_osm(path, everything=True)
        if progress:
            progress(f"{name}: {len(maps[name].of_kind('building'))} buildings")
    return maps


@dataclass(frozen=True)
class FrameLabel:
    """Which way a building faces.

    Parameters
    ----------
    building
        Id of the building.
    frame_angle_rad
        The direction, radians anticlockwise from east.
    """

    building: str
    frame_angle_rad: float


def address_labels(city: CityMap, buildings: Iterable[str] | None = None) -> list[FrameLabel]:
    """Return the front of each building that tells the street of its address.

    Parameters
    ----------
    buildings
        Ids of those to look at; all buildings when None.

    Notes
    -----
    The rule: a building faces the nearest point, from its centroid, of the street or square that
    `addr:street` names. An address whose street is more than 60 m from the building's wall tells
    nothing of its front, nor does one whose street is not on the map.
    """
    labels = []
    for building in _ids(city, buildings):
        facing = city.frontage(building).by_address
        if facing is None:
            continue
        if shapely.Point(facing.point_m).distance(city.footprint(building)) <= _WITHIN_M:
            labels.append(FrameLabel(building, facing.bearing_rad))
    return labels


def entrance_labels(city: CityMap, buildings: Iterable[str] | None = None) -> list[FrameLabel]:
    """Return the front of each building whose main entrance is known: out of its wall."""
    found = ((b, city.frontage(b).by_entrance) for b in _ids(city, buildings))
    return [FrameLabel(b, facing.bearing_rad) for b, facing in found if facing is not None]


@dataclass(frozen=True, eq=False)
class Batch:
    """What a network takes, and the fronts it should tell.

    Shape legend: N buildings, C streets, F features.
    """

    pictures: Tensor
    bearing_rad: Tensor
    features: Tensor
    there: Tensor
    frame_angle_rad: Tensor


@dataclass(frozen=True, eq=False)
class FrameExamples:
    """Labelled buildings, each drawn several times, turned and shifted.

    Shape legend: N buildings, R drawings of each, C streets, F features.

    Parameters
    ----------
    pictures
        Planes as uint8, 255 for whole, shape (N, R, 4, 28, 28).
    turns_rad
        By how much the scene of each drawing is turned, shape (N, R).
    bearing_rad, features, there
        Streets around each, shape (N, C), (N, C, F), (N, C).
    frame_angle_rad
        The label, shape (N,).
    """

    pictures: Tensor
    turns_rad: Tensor
    bearing_rad: Tensor
    features: Tensor
    there: Tensor
    frame_angle_rad: Tensor

    def __len__(self) -> int:
        return len(self.frame_angle_rad)

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
        frame_angle = self.frame_angle_rad[which] + angle
        return Batch(
            pictures,
            torch.where(mirrored[:, None], -bearing, bearing),
            self.features[which],
            self.there[which],
            torch.where(mirrored, -frame_angle, frame_angle),
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
    labels
        Buildings and their fronts.
    view
        The picture to draw; see :data:`sloop_ppl.models.frames.VIEWS`.
    drawings
        How often each building is drawn, > 0; turned by any angle, shifted by a few metres, a
        picture that is not centred by up to half its side.
    rng
        Draws turns and shifts, a stream for each building.

    Raises
    ------
    InputError
        When a label is no finite angle.
    """
    for label in labels:
        if not math.isfinite(label.frame_angle_rad):
            raise InputError(
                f"The front of '{label.building}' on map '{city.name}' is {label.frame_angle_rad}; "
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
        torch.tensor([label.frame_angle_rad for label in labels], dtype=torch.float32),
    )


def examples_of_maps(
    maps: Mapping[str, CityMap],
    view: str,
    *,
    rng: np.random.Generator,
    progress: Callable[[str], None] | None = None,
    annotated: Mapping[str, Sequence[FrameLabel]] = MappingProxyType({}),
) -> dict[str, FrameExamples]:
    """Return the examples of each map that has labels, by the map's name.

    Parameters
    ----------
    annotated
        Labels that people gave, in place of those of addresses, by the map's name.
    """
    found = {}
    for name, city in maps.items():
        labels = list(annotated[name]) if name in annotated else address_labels(city)
        if labels:
            found[name] = frame_examples(city, labels, view, rng=rng)
        if progress:
            progress(f"{name}: {len(labels)} labelled buildings")
    return found


def joined(sets: Sequence[FrameExamples]) -> FrameExamples:
    """Return the examples of several maps as one.

    Raises
    ------
    InputError
        When there is none.
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
        torch.cat([e.frame_angle_rad for e in some]),
    )


def _ids(city: CityMap, buildings: Iterable[str] | None) -> Iterable[str]:
    return (b.id for b in city.of_kind("building")) if buildings is None else buildings


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

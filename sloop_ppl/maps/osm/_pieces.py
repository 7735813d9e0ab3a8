"""Landmarks in the making: what a feature becomes before pieces are joined and ids are given."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sloop_ppl.maps._shapes import clip, repair
from sloop_ppl.maps.grid import Grid
from sloop_ppl.maps.osm._classify import Sort, classify, is_underground
from sloop_ppl.maps.osm._feature import OsmFeature
from sloop_ppl.maps.osm._feature_names import name_of
from sloop_ppl.maps.osm.import_report import ImportReport

__all__ = ["Piece", "pieces_of", "projected"]


@dataclass
class Piece:
    """A landmark in the making.

    Parameters
    ----------
    sources
        The features it is made of, the first one gives it its place in the order.
    kind, word
        See `Sort`.
    tags
        Tags, of the largest feature when there are several.
    geometry
        Metres, cut to the extent.
    aliases
        Other names.
    properties
        What is derived for it, beside the kept tags.
    """

    sources: list[str]
    kind: str
    word: str
    name: str | None
    tags: dict[str, str]
    geometry: BaseGeometry
    aliases: tuple[str, ...] = ()
    properties: dict[str, Any] = field(default_factory=dict)

    @property
    def is_line(self) -> bool:
        """Whether it is a line or several."""
        return bool(shapely.get_dimensions(self.geometry) == 1)

    @property
    def is_area(self) -> bool:
        """Whether it is an area or several."""
        return bool(shapely.get_dimensions(self.geometry) == 2)


def projected(features: list[OsmFeature], grid: Grid) -> list[OsmFeature]:
    """Return features with their geometry in the grid's frame, metres, all converted at once."""
    # One call of pyproj for all coordinates.
    shapes = np.array([f.geometry for f in features] + [f.outline for f in features], dtype=object)

    def each(lonlat: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        return np.column_stack(grid.from_lonlat(lonlat[:, 0], lonlat[:, 1]))

    moved = shapely.transform(shapes, each)
    areas, outlines = moved[: len(features)], moved[len(features) :]
    return [
        replace(f, geometry=a, outline=o) for f, a, o in zip(features, areas, outlines, strict=True)
    ]


def pieces_of(features: list[OsmFeature], grid: Grid, report: ImportReport) -> list[Piece]:
    """Return what features can be landmarks of, valid and cut to the extent."""
    found = []
    for feature in features:
        sort, geometry = _sorted_out(feature)
        if sort is None:
            report.of_no_kind += 1
        elif is_underground(feature.tags):
            report.underground += 1
        elif (sound := _sound(geometry, feature.source, report)) is not None:
            inside = clip(sound, grid.extent_m)
            if inside is None:
                report.outside += 1
            else:
                name = name_of(feature.tags)
                found.append(
                    Piece([feature.source], sort.kind, sort.word, name, feature.tags, inside)
                )
    return found


def _sorted_out(feature: OsmFeature) -> tuple[Sort | None, BaseGeometry]:
    """Return what a feature is and its geometry: a closed way may be an area or a line."""
    dimension = shapely.get_dimensions(feature.geometry)
    shape = ("point", "line", "area")[dimension]
    sort = classify(feature.tags, shape)
    # A closed way that is nothing as an area may be a ring road or a roundabout.
    if sort is None and feature.outline is not None:
        return classify(feature.tags, "line"), feature.outline
    return sort, feature.geometry


def _sound(geometry: BaseGeometry, source: str, report: ImportReport) -> BaseGeometry | None:
    if shapely.get_dimensions(geometry) < 2 or geometry.is_valid:
        return geometry
    repaired = repair(geometry)
    (report.broken if repaired is None else report.repaired).append(source)
    return repaired

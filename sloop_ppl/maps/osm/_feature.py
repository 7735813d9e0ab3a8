"""What the importer works on: one tagged shape, as OpenStreetMap has it."""

from __future__ import annotations

from dataclasses import dataclass, field

from shapely.geometry.base import BaseGeometry

__all__ = ["OsmData", "OsmFeature", "source_key"]

_ORDER = {"node": 0, "way": 1, "relation": 2}


@dataclass(frozen=True)
class OsmFeature:
    """A node, way or multipolygon relation with its tags.

    Parameters
    ----------
    source
        Where it comes from, such as ``"way/123"``.
    tags
        Its tags.
    geometry
        Point, line or area; a closed way is an area. Degrees (lon, lat) as read, metres once it is
        projected.
    outline
        For a closed way, its line: a ring road is no area.
    """

    source: str
    tags: dict[str, str]
    geometry: BaseGeometry
    outline: BaseGeometry | None = None


@dataclass
class OsmData:
    """What a file holds within some bounds.

    Parameters
    ----------
    features
        Tagged shapes, in degrees.
    street_of
        Street by source, from relations that tie houses to their street.
    bounds
        West, south, east, north of the file in degrees; None when it does not say and is empty.
    """

    features: list[OsmFeature] = field(default_factory=list)
    street_of: dict[str, str] = field(default_factory=dict)
    bounds: tuple[float, float, float, float] | None = None


def source_key(source: str) -> tuple[int, int]:
    """Return what to sort sources by: nodes, ways, relations, each by number.

    Examples
    --------
    >>> sorted(["way/10", "relation/1", "way/9", "node/5"], key=source_key)
    ['node/5', 'way/9', 'way/10', 'relation/1']
    """
    sort, _, number = source.partition("/")
    return _ORDER[sort], int(number)

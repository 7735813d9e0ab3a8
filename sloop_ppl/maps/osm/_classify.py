"""Decide which kind of landmark an OpenStreetMap feature is, if any."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from sloop_ppl.maps._symbols import camel_case

__all__ = ["STREET_CLASSES", "Sort", "classify", "is_underground"]


class Sort(NamedTuple):
    """A kind of landmark, and the word that ids of nameless ones begin with."""

    kind: str
    word: str


STREET_CLASSES: dict[str, Sort] = {
    **{
        name: Sort("street", "Street")
        for name in (
            "motorway", "trunk", "primary", "secondary", "tertiary", "unclassified",
            "residential", "living_street", "road", "busway",
        )
    },
    **{
        f"{name}_link": Sort("street", "Ramp")
        for name in ("motorway", "trunk", "primary", "secondary", "tertiary")
    },
    "service": Sort("service", "ServiceRoad"),
    "track": Sort("service", "Track"),
    "pedestrian": Sort("pedestrian", "PedestrianStreet"),
    "footway": Sort("pedestrian", "Footway"),
    "path": Sort("pedestrian", "Path"),
    "steps": Sort("pedestrian", "Steps"),
    "cycleway": Sort("pedestrian", "Cycleway"),
    "bridleway": Sort("pedestrian", "Bridleway"),
}  # fmt: skip
"""Values of ``highway`` that make a line a path."""

_WATERWAYS = {"river": "River", "canal": "Canal", "stream": "Stream"}
_PARKS = {
    ("leisure", "park"): "Park", ("leisure", "garden"): "Garden", ("leisure", "common"): "Common",
    ("leisure", "dog_park"): "DogPark", ("leisure", "playground"): "Playground",
    ("leisure", "nature_reserve"): "NatureReserve", ("landuse", "grass"): "GreenArea",
    ("landuse", "recreation_ground"): "RecreationGround", ("landuse", "village_green"): "Green",
    ("landuse", "cemetery"): "Cemetery", ("amenity", "grave_yard"): "Graveyard",
    ("landuse", "forest"): "Wood", ("natural", "wood"): "Wood",
}  # fmt: skip
_WATERS = {
    ("natural", "water"): "Water", ("waterway", "riverbank"): "River", ("waterway", "dock"): "Dock",
    ("landuse", "reservoir"): "Reservoir", ("landuse", "basin"): "Basin",
    ("leisure", "swimming_pool"): "SwimmingPool",
}  # fmt: skip
# The first of these that a feature has says what it is.
_POI_KEYS = (
    "amenity", "shop", "tourism", "historic", "leisure", "office", "craft", "healthcare",
    "railway", "highway", "public_transport", "aeroway", "man_made", "club", "diplomatic",
)  # fmt: skip
_POI_VALUES = {
    "railway": {"station", "halt", "tram_stop", "subway_entrance", "train_station_entrance"},
    "highway": {"bus_stop"},
    "public_transport": {"station"},
    "aeroway": {"terminal", "helipad", "gate"},
    "man_made": {
        "tower", "water_tower", "lighthouse", "windmill", "chimney", "obelisk", "cross", "crane",
        "communications_tower", "observatory", "clock",
    },
}  # fmt: skip
"""Keys of which only some values are places."""
_ONLY_NAMED = {
    "bench", "waste_basket", "waste_disposal", "vending_machine", "parking_space",
    "parking_entrance", "motorcycle_parking", "loading_dock", "smoking_area", "grit_bin",
    "recycling", "hunting_stand", "lounger", "table", "trolley_bay", "information",
    "picnic_table", "outdoor_seating", "firepit", "pitch", "track", "give_box",
}  # fmt: skip
"""Furniture of the street, which nobody names by its kind alone."""
_NAMED_AREAS = ("landuse", "place", "natural")
"""Keys whose areas are places when they have a name."""


def classify(tags: Mapping[str, str], shape: str) -> Sort | None:
    """Return the kind of landmark a feature is.

    Parameters
    ----------
    shape
        ``"point"``, ``"line"`` or ``"area"``.

    Returns
    -------
    Sort or None
        None when it is nothing that people would refer to.

    Examples
    --------
    >>> classify({"building": "yes", "amenity": "cafe"}, "area").kind
    'building'
    >>> classify({"highway": "service"}, "line")
    Sort(kind='service', word='ServiceRoad')
    """
    if shape == "line":
        return _line(tags)
    if shape == "area":
        return _area(tags) or _poi(tags, area=True)
    if tags.get("place") == "square" and "name" in tags:
        return Sort("square", "Square")
    return _poi(tags, area=False)


def is_underground(tags: Mapping[str, str]) -> bool:
    """Tell whether a road, parking or building lies below ground, or inside a building.

    A shop in a basement does not count: one still says "the kiosk" of it.
    """
    if tags.get("location") == "underground" or tags.get("parking") == "underground":
        return True
    # Several levels in one tag are parted by ";": below only if all of them are.
    below = any(_negative(tags.get(key, "")) for key in ("layer", "level"))
    if "highway" in tags and tags["highway"] != "bus_stop":
        tunnel = tags.get("tunnel", "no") not in ("no", "building_passage", "avalanche_protector")
        return tunnel or below or tags.get("indoor", "no") != "no"
    return below and ("building" in tags or "waterway" in tags or tags.get("amenity") == "parking")


def _negative(value: str) -> bool:
    try:
        return all(float(part) < 0 for part in value.split(";"))
    except ValueError:
        return False


def _line(tags: Mapping[str, str]) -> Sort | None:
    highway = tags.get("highway")
    if highway in STREET_CLASSES:
        alley = highway == "service" and tags.get("service") == "alley"
        return Sort("service", "Alley") if alley else STREET_CLASSES[highway]
    waterway = tags.get("waterway")
    return Sort("water", _WATERWAYS[waterway]) if waterway in _WATERWAYS else None


def _area(tags: Mapping[str, str]) -> Sort | None:
    building = tags.get("building", "no")
    parking = tags.get("amenity") == "parking"
    if building not in ("no", "entrance"):
        garage = parking or building in ("parking", "garages")
        return Sort("building", "ParkingGarage" if garage else "Building")
    highway = tags.get("highway")
    if tags.get("place") == "square":
        return Sort("square", "Square")
    if highway in STREET_CLASSES:
        if tags.get("area", "no") == "no":
            return None
        kind = STREET_CLASSES[highway].kind
        if highway == "pedestrian" and "name" in tags:
            return Sort("square", "Square")
        return Sort("service" if kind == "service" else "pedestrian", f"{camel_case(kind)}Area")
    if parking:
        return Sort("parking", "ParkingLot")
    for kind, table in (("park", _PARKS), ("water", _WATERS)):
        for (key, value), word in table.items():
            if tags.get(key) == value:
                return Sort(kind, word)
    return None


def _poi(tags: Mapping[str, str], area: bool) -> Sort | None:
    named = "name" in tags or "brand" in tags
    for key in _POI_KEYS:
        value = tags.get(key)
        if value is None or value in ("no", "vacant") or value not in _POI_VALUES.get(key, {value}):
            continue
        if value in _ONLY_NAMED and not named:
            continue
        return Sort("poi", camel_case(key if value == "yes" else value.split(";")[0]) or "Place")
    if area and "name" in tags and any(key in tags for key in _NAMED_AREAS):
        # A named quarter or hamlet covers whole streets: nobody is "near" it.
        if tags.get("place", "square") not in ("square", "city_block", "plot"):
            return None
        return Sort("poi", "Place")
    return None

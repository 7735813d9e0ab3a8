"""A hand-made block in OpenStreetMap XML, with places given in metres round a centre."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

from sloop_ppl.maps import Grid

CENTRE = (41.5, -81.7)
FRAME = Grid.square(500.0, 5.0, CENTRE)


class OsmWriter:
    """Writes nodes, ways and relations as OpenStreetMap XML; places are (x, y) in metres."""

    def __init__(self) -> None:
        self.nodes: list[str] = []
        self.ways: list[str] = []
        self.relations: list[str] = []
        self._places: dict[tuple[float, float], int] = {}

    def node(self, x: float, y: float, number: int | None = None, **tags: str) -> int:
        if not tags and number is None and (x, y) in self._places:
            return self._places[x, y]
        number = number or 1000 + len(self.nodes)
        self._places.setdefault((x, y), number)
        lon, lat = FRAME.to_lonlat(x, y)
        self.nodes.append(
            f'<node id="{number}" lat="{lat:.9f}" lon="{lon:.9f}" version="1">{_tags(tags)}</node>'
        )
        return number

    def way(self, number: int, *places: tuple[float, float], version: int = 1, **tags: str) -> int:
        refs = "".join(f'<nd ref="{self.node(*place)}"/>' for place in places)
        self.ways.append(f'<way id="{number}" version="{version}">{refs}{_tags(tags)}</way>')
        return number

    def box(self, number: int, west: float, south: float, east: float, north: float, **tags: str):
        corners = [(west, south), (east, south), (east, north), (west, north), (west, south)]
        return self.way(number, *corners, **tags)

    def relation(self, number: int, *members: tuple[str, int, str], **tags: str) -> int:
        told = "".join(
            f'<member type="{sort}" ref="{ref}" role="{role}"/>' for sort, ref, role in members
        )
        self.relations.append(f'<relation id="{number}" version="1">{told}{_tags(tags)}</relation>')
        return number

    def text(self) -> str:
        body = "\n".join([*self.nodes, *self.ways, *self.relations])
        return f'<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6">\n{body}\n</osm>\n'

    def write(self, path: Path) -> Path:
        path.write_text(self.text(), encoding="utf-8")
        return path


def block() -> OsmWriter:
    """Return a block of four buildings between two streets, with all that an import deals with.

    Main Street runs east at y = -20 in two pieces, Oak Avenue north at x = 0. The bank is at the
    north side of Main Street, its main door in the south wall; the shop has its address on Oak
    Avenue; the court has a hole; nameless is nameless.
    """
    osm = OsmWriter()
    osm.way(10, (-80, -20), (0, -20), highway="residential", name="Main Street")
    osm.way(11, (0, -20), (90, -20), highway="secondary", name="Main Street", lanes="2")
    osm.way(12, (0, -90), (0, 90), highway="residential", name="Oak Avenue", alt_name="Oak Ave")
    osm.way(13, (20, -20), (20, 80), highway="service", service="alley")
    osm.way(14, (-80, 60), (-5, 60), highway="footway")
    osm.way(15, (-80, 70), (-5, 70), highway="footway", tunnel="yes", layer="-1")
    osm.box(
        20, -60, -10, -30, 10, building="yes", name="First Bank", amenity="bank", height="40 ft",
        **{"addr:street": "Main Street", "addr:housenumber": "12"},
    )  # fmt: skip
    osm.box(
        21, -25, 20, -5, 40, building="retail", **{"addr:street": "Oak Ave", "building:levels": "3"}
    )
    osm.box(22, 30, 10, 70, 50)
    osm.box(23, 40, 20, 60, 40)
    osm.relation(
        30, ("way", 22, "outer"), ("way", 23, "inner"), type="multipolygon", building="yes",
        name="The Court",
    )  # fmt: skip
    osm.box(24, 30, -60, 50, -40, building="yes")
    osm.box(25, -70, -80, -20, -40, leisure="park", name="Green Park")
    osm.box(26, 60, -80, 90, -40, amenity="parking")
    osm.node(-45, -10, 100, entrance="main")
    osm.node(-60, 0, 101, entrance="yes")
    osm.node(-15, 30, 102, amenity="cafe", name="Joe's", cuisine="coffee_shop")
    osm.node(10, -30, 103, highway="bus_stop")
    osm.node(-10, 25, 104, amenity="cafe", name="Joe's")
    osm.node(35, 30, 105, shop="yes")
    osm.node(-15, 20, 106, **{"addr:housenumber": "7", "addr:street": "Oak Ave"})
    osm.node(5, 5, 107, amenity="bench")
    return osm


def _tags(tags: dict[str, str]) -> str:
    return "".join(f"<tag k={quoteattr(k)} v={quoteattr(v)}/>" for k, v in tags.items())

"""Rebuild sloop_ppl/data/kinds/osm.json from the presets of OpenStreetMap's iD editor.

Run: npm pack @openstreetmap/id-tagging-schema@7.2.0 && tar xzf openstreetmap-id-*.tgz
     python tests/tools/build_kinds.py package
     python tests/tools/build_kinds.py package --check

The file holds, of each preset that is a place, the tags it requires and what it is called in
English: names and aliases, and of its search terms those that name the place. Terms are there for
searching, and most are no names ("trust" finds a bank): one of one word is kept when it is in
`TERMS`, a longer one when its last word ends a name of some preset and is not in `NOT_LAST`. The
version of the package is written into the file; the same package gives the same bytes. `--check`
compares and writes nothing.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

TARGET = Path(__file__).parents[2] / "sloop_ppl" / "data" / "kinds" / "osm.json"
KEYS = frozenset((
    "advertising", "aerialway", "aeroway", "amenity", "attraction", "barrier", "building", "club",
    "craft", "emergency", "healthcare", "highway", "historic", "landuse", "leisure", "man_made",
    "natural", "office", "power", "public_transport", "railway", "shop", "telecom", "tourism",
    "traffic_calming", "waterway",
))  # fmt: skip
"""Keys of OpenStreetMap whose presets are places."""
_TERMS = """
    abattoir abbey aerodrome airport apothecary aquarium armory atm auditorium b&b bakehouse
    bakeshop ballpark ballroom barbershop basilica belfry bistro bnb boathouse boutique
    brasserie brewery brownstone bubbler bungalow butchery cabaret cafe campground campsite
    canteen canyon carvery casino cathedral cattery cemetery chapel chemist churchyard citadel
    cobbler columbarium consulate courthouse cove creek crosswalk cybercafe cycleway daycare
    deli depot dhaba discotheque dispensary doctor dojo dormitory drugstore duplex embassy
    estuary factory fen firehouse firepit fireplace fjord floodbank fortress freeway gallery
    garage garden gazebo glacier glasshouse glen gorge graveyard greengrocer greenhouse greenway
    grocery grotto guardrail gurudwara gym hackspace hairdresser hangar harbor helipad heliport
    highway houseboat infirmary inlet interstate islet jail jetty jeweler jeweller kennel
    kindergarten kiosk laboratory lagoon lakelet latrine laundry lavatory lawyer library
    lighthouse loch locker lunchroom mailbox makerspace mandir mansion marina market marsh
    masjid mausoleum metro microbrewery milepost milestone mill millpond minster monastery
    monorail monument mosque mortuary multiplex museum newsagent newsstand nightclub noticeboard
    observatory oilfield orchard orphanage outhouse overlook packstation pagoda parkade parking
    parkland parkway pasture patisserie payphone pharmacy pier pigpen pillarbox playground plaza
    pond postbox prairie pub pumpjack quagmire racecourse racetrack raceway rail railway ravine
    refinery reservoir restaurant restroom riverbank rivulet road roadhouse roundabout salon
    saltmarsh sanatorium sanctuary sanitarium sandpit school shrine skatepark skywalk sorority
    soundwall spillway stables staircase stairs stairway statue stockyard stoplight store
    storefront stream streetlight stupa substation subway swamp synagogue tabernacle tarn tavern
    taxiway tearoom temple tenement theater theatre thruway tollbooth towpath townhome trailway
    tramway tributary turnpike turnstyle velodrome viaduct vihara warehouse walkway watercourse
    wc wetland wharf whiteboard windmill woodland workshop zipline zoo
"""
TERMS = frozenset(_TERMS.split())
_NOT_LAST = """
    area bar cars conveying cure fast food feature footing goods grass link medicine on place
    pulling road rope sand site table type use up water work yes
"""
NOT_LAST = frozenset(_NOT_LAST.split())
DROPPED = re.compile(r"\s+(?:grounds|counter)$|\s*\([^)]*\)")
"""Endings that nobody says: the preset of schools is called "School Grounds"."""


def main() -> int:
    """Do what is asked."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("package", type=Path, help="the unpacked npm package")
    options.add_argument("--check", action="store_true", help="compare, and write nothing")
    given = options.parse_args()
    text = kinds_file(given.package)
    if not given.check:
        TARGET.write_text(text, encoding="utf-8")
    elif TARGET.read_text(encoding="utf-8") != text:
        print(f"{TARGET.name} is not what this package gives")
        return 1
    print(f"{TARGET.name}: {len(text.encode()):,} bytes, as this package gives it")
    return 0


def kinds_file(package: Path) -> str:
    """Return the text of the file, one kind a line."""
    version = _read(package / "package.json")["version"]
    presets = _read(package / "dist" / "presets.json")
    english = _read(package / "dist" / "translations" / "en.json")["en"]["presets"]
    spoken = english["presets"]
    chosen = {k: p for k, p in presets.items() if k.split("/")[0] in KEYS and _is_place(k, p)}
    names = {k: _names(spoken.get(k, {})) for k in chosen}
    last = {name.split()[-1] for given in names.values() for name in given} | TERMS
    rows = []
    for key, preset in sorted(chosen.items()):
        if not names[key]:
            continue
        terms = _terms(spoken[key].get("terms", ()), last - NOT_LAST)
        tags = " ".join(f"{k}={v}" for k, v in preset["tags"].items())
        rows.append([tags, names[key], [t for t in terms if t not in names[key]]])
    cuisines = {
        label.lower(): value for value, label in english["fields"]["cuisine"]["options"].items()
    }
    head = {
        "about": "Kinds of places: required tags, English names, and terms that name the place. "
        "Derived from the presets of @openstreetmap/id-tagging-schema (ISC licence, see "
        "NOTICE.md) by tests/tools/build_kinds.py.",
        "package": "@openstreetmap/id-tagging-schema",
        "version": version,
    }
    lines = [f" {_json(k)}: {_json(v)},\n" for k, v in head.items()]
    listed = ",\n".join(f"  {_json(row)}" for row in rows)
    return f'{{\n{"".join(lines)} "cuisines": {_json(cuisines)},\n "kinds": [\n{listed}\n ]\n}}\n'


def _is_place(key: str, preset: dict[str, Any]) -> bool:
    """Whether a preset has tags of its own, and is not all of a key at large."""
    tags = preset["tags"]
    whole = len(tags) == 1 and "*" in tags.values() and "/" not in key
    return bool(tags) and not key.endswith("/yes") and (not whole or key in ("shop", "office"))


def _names(spoken: dict[str, Any]) -> list[str]:
    """Return the name and the aliases of a preset, alternatives parted, in lower case."""
    given = [spoken["name"], *spoken.get("aliases", ())] if spoken.get("name") else []
    found = [DROPPED.sub("", n) for name in given for n in _alternatives(name.lower())]
    return [n for n in dict.fromkeys(found) if n and not n.startswith("{")]


def _alternatives(name: str) -> Iterable[str]:
    """Part "bus station / terminal" into "bus station" and "bus terminal"."""
    first, *others = re.split(r"\s+/\s+", name)
    yield first
    stem = first.split()[:-1]
    for other in others:
        yield " ".join([*stem, other]) if len(other.split()) == 1 else other


def _terms(terms: Iterable[str], last: Iterable[str]) -> list[str]:
    """Return those search terms that name the place itself."""
    kept = [t.strip().lower() for t in terms]
    return sorted({
        t for t in kept if (t in TERMS if " " not in t else t.split()[-1] in last)
    })  # fmt: skip


def _read(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


if __name__ == "__main__":
    sys.exit(main())

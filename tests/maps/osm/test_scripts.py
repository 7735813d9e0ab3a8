"""A place can be asked for in Latin letters, whatever script its name is written in."""

import pytest
from support.osm_block import CENTRE, block

from sloop_ppl.maps.osm import import_osm
from sloop_ppl.maps.osm._feature_names import aliases

BLUE, MOUNTAIN, STATION, HOUSE = "青い花", "蓝山", "서울역", "Синий дом"


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ({"name": BLUE, "name:ja-Latn": "Aoi Hana"}, ("Aoi Hana",)),
        ({"name": BLUE, "name:ja_rm": "Aoi Hana"}, ("Aoi Hana",)),
        ({"name": MOUNTAIN, "name:zh-Latn-pinyin": "Lan Shan"}, ("Lan Shan",)),
        ({"name": MOUNTAIN, "name:zh_pinyin": "Lan Shan;Lán Shān"}, ("Lan Shan",)),
        ({"name": MOUNTAIN, "name:zh-Hant": "藍山"}, ("LanShan",)),
        ({"name": STATION, "name:ko-Latn": "Seoul-yeok", "name:en": "Seoul Station"},
         ("Seoul Station", "Seoul-yeok")),
        ({"name": HOUSE, "int_name": "Siniy dom"}, ("Siniy dom",)),
        ({"name": HOUSE}, ("Siniy dom",)),
        ({"name": HOUSE, "alt_name": "Дом"}, ("Дом", "Siniy dom")),
        ({"name": HOUSE, "operator": "Example Ltd", "addr:street": "Lane", "addr:housenumber": "3"},
         ("Example Ltd", "Siniy dom", "3 Lane")),
        ({"name": "Αθήνα"}, ("Athina",)),
        ({"name": "Café Größe №"}, ()),
        ({"name": "🍕"}, ()),
        ({"name": "Main Street", "name:sr-Latn": "Glavna"}, ("Glavna",)),
    ],
)  # fmt: skip
def test_names_in_latin_letters_are_aliases_and_else_a_transliteration(tags, expected):
    assert aliases(tags, tags["name"]) == expected


def test_a_place_is_found_by_what_people_who_cannot_write_it_say(tmp_path):
    osm = block()
    osm.node(-50, 40, 300, amenity="cafe", name=BLUE, **{"name:ja-Latn": "Aoi Hana"})
    osm.node(-40, 40, 301, shop="books", name=HOUSE)
    town, _ = import_osm(osm.write(tmp_path / "a.osm"), centre=CENTRE, side_m=200.0)
    assert [m.name for m in town.find("aoi hana")] == [BLUE]
    assert [m.name for m in town.find("the Siniy Dom")] == [HOUSE]
    assert [m.name for m in town.find(HOUSE)] == [HOUSE]

"""Noun phrases name kinds of places by their tags; ordinary words name none."""

from __future__ import annotations

import json
import sys
from importlib.resources import files

import pytest
import shapely
from support.tree import ROOT, run_python

import sloop_ppl as sloop
from sloop_ppl.language.kind_vocabulary import kind_vocabulary, phrase_words
from sloop_ppl.language.kinds import is_kind_noun, kinds_of, landmarks_of_kind
from sloop_ppl.maps import CityMap, Landmark, bundled_maps

SUREST = {
    "pharmacy": "amenity=pharmacy", "drugstore": "amenity=pharmacy", "chemist": "amenity=pharmacy",
    "gas station": "amenity=fuel", "petrol station": "amenity=fuel", "fuel station": "amenity=fuel",
    "car park": "kind=parking", "parking lot": "kind=parking", "parking": "kind=parking",
    "parking garage": "kind=building amenity=parking",
    "multi-storey car park": "kind=building amenity=parking",
    "bike rack": "amenity=bicycle_parking", "bicycle parking": "amenity=bicycle_parking",
    "bike share station": "amenity=bicycle_rental", "cycle hire": "amenity=bicycle_rental",
    "car sharing": "amenity=car_sharing", "car rental": "amenity=car_rental",
    "bus stop": "highway=bus_stop", "bus station": "amenity=bus_station",
    "train station": "railway=station", "tube station": "railway=station station=subway",
    "subway entrance": "railway=subway_entrance", "taxi rank": "amenity=taxi",
    "fast food restaurant": "amenity=fast_food", "takeaway": "amenity=fast_food",
    "food court": "amenity=food_court", "restaurant": "amenity=restaurant",
    "italian restaurant": "amenity=restaurant cuisine=italian", "burger place": "cuisine=burger",
    "thai food place": "cuisine=thai", "pizza joint": "cuisine=pizza",
    "coffee shop": "amenity=cafe", "café": "amenity=cafe", "bar": "amenity=bar",
    "pub": "amenity=pub", "tavern": "amenity=pub", "night club": "amenity=nightclub",
    "bank": "amenity=bank", "atm": "amenity=atm", "cash machine": "amenity=atm",
    "post office": "amenity=post_office", "post box": "amenity=post_box",
    "mailbox": "amenity=post_box", "school": "amenity=school", "library": "amenity=library",
    "kindergarten": "amenity=kindergarten", "university": "amenity=university",
    "dorm": "building=dormitory", "hospital": "amenity=hospital", "doctor's office":
    "amenity=clinic", "dentist": "amenity=dentist", "vet": "amenity=veterinary",
    "church": "amenity=place_of_worship religion=christian",
    "mosque": "amenity=place_of_worship religion=muslim", "police station": "amenity=police",
    "firehouse": "amenity=fire_station", "city hall": "amenity=townhall",
    "social facility": "amenity=social_facility",
    "food bank": "amenity=social_facility social_facility=food_bank",
    "theatre": "amenity=theatre", "theater": "amenity=theatre", "movie theater": "amenity=cinema",
    "fountain": "amenity=fountain", "bench": "amenity=bench", "rubbish bin": "amenity=waste_basket",
    "public toilet": "amenity=toilets", "phone box": "amenity=telephone",
    "grocery": "shop=supermarket", "corner shop": "shop=convenience", "bakery": "shop=bakery",
    "off-licence": "shop=alcohol", "bookshop": "shop=books", "barber": "shop=hairdresser",
    "laundromat": "shop=laundry", "hardware store": "shop=hardware", "store": "shop=*",
    "cheese shop": "shop=cheese", "florist": "shop=florist", "mall": "shop=mall",
    "gym": "leisure=fitness_centre", "playground": "leisure=playground", "park": "leisure=park",
    "dog park": "leisure=dog_park", "tennis court": "sport=tennis", "hotel": "tourism=hotel",
    "museum": "tourism=museum", "statue": "tourism=artwork", "office": "office=*",
    "alley": "service=alley", "crosswalk": "highway=crossing", "pavement": "footway=sidewalk",
    "staircase": "highway=steps", "street": "kind=street", "road": "kind=street",
    "building": "kind=building", "square": "kind=square", "lake": "water=lake",
    "riverbank": "waterway=riverbank", "block of flats": "building=apartments",
    "apartment building": "building=apartments", "fire hydrant": "emergency=fire_hydrant",
    "water tower": "man_made=water_tower", "ice cream parlour": "amenity=ice_cream",
    "bowling alley": "leisure=bowling_alley", "wine shop": "shop=alcohol",
}  # fmt: skip
_ORDINARY = """
    open fast red place back light stand play walk run stop turn go see find look near left
    right north corner side end front top middle thing object person people man dog cat car
    truck bicycle meter foot mile minute hour day time way kind sort part piece number name word
    point line area space spot location direction distance block cross crossing step entrance
    exit big small tall old new quiet busy green blue white empty closed public private stable
    between behind across from the and or not with of work rest drive ride change watch check
    service help hold cut draw fall spring rock stone common plain safe trust deposit table sign
    flat cleaner ruin movie home hand map
"""
ORDINARY = _ORDINARY.split()


def joined(kind):
    return " ".join(f"{key}={value}" for key, value in kind.tags)


def tags(phrase):
    return [joined(kind) for kind in kinds_of(phrase)]


@pytest.mark.parametrize("phrase", SUREST)
def test_a_phrase_names_its_kind(phrase):
    assert tags(phrase)[0] == SUREST[phrase]


@pytest.mark.parametrize(
    ("plural", "singular"),
    [
        ("pharmacies", "pharmacy"), ("churches", "church"), ("mailboxes", "mailbox"),
        ("bike racks", "bike rack"), ("buses stops", "bus stop"), ("bus stops", "bus stop"),
        ("libraries", "library"), ("coffee houses", "coffee house"), ("atms", "atm"),
        ("farmers' markets", "farmers market"), ("the gas stations", "gas station"),
        ("any banks", "bank"), ("Bakeries", "bakery"), ("tennis courts", "tennis court"),
    ],
)  # fmt: skip
def test_plural_article_and_capital_do_not_matter(plural, singular):
    assert kinds_of(plural) == kinds_of(singular) != ()


@pytest.mark.parametrize("word", ORDINARY)
def test_an_ordinary_word_is_no_kind(word):
    assert not is_kind_noun(word)


@pytest.mark.parametrize("word", ["flats", "cleaners", "ruins", "bank", "shops", "school", "b&b"])
def test_a_kind_noun_is_one(word):
    assert is_kind_noun(word)


@pytest.mark.parametrize(
    ("phrase", "modifiers"),
    [
        ("red brick building", ("red", "brick")),
        ("big bank", ("big",)),
        ("the other two parking lots", ("other", "two")),
        ("bike rack", ()),
        ("fast food restaurant", ()),
    ],
)
def test_words_before_the_kind_are_kept(phrase, modifiers):
    assert {kind.modifiers for kind in kinds_of(phrase)} == {modifiers}
    assert not modifiers or not is_kind_noun(phrase)


@pytest.mark.parametrize(
    "phrase",
    [
        "snow bank",
        "fight club",
        "handle bar",
        "",
        "the",
        "bank of",
        "xyzzy",
        "very open",
        "long stop",
    ],
)
def test_another_thing_is_no_kind(phrase):
    assert kinds_of(phrase) == ()


def test_a_bank_is_no_river_bank():
    assert tags("bank") == ["amenity=bank"]
    assert not any("amenity" in t for t in tags("river bank"))


def test_a_shared_term_goes_to_the_preset_of_that_name():
    table = json.loads((files("sloop_ppl") / "data/kinds/osm.json").read_text("utf-8"))["kinds"]
    named = {phrase_words(name) for row in table for name in row[1]}
    shared = {phrase_words(t) for row in table for t in row[2]} & named
    by_name = kind_vocabulary().by_name
    assert len(shared) > 20
    for words in shared:
        bearing = {row[0] for row in table if words in {phrase_words(name) for name in row[1]}}
        assert {joined(kind) for kind in by_name[words]} == bearing


def test_every_row_is_well_formed():
    known = kind_vocabulary()
    kinds = {k for table in (known.by_hand, known.by_name) for ks in table.values() for k in ks}
    assert all(kind.tags and all(key and " " not in key for key, _ in kind.tags) for kind in kinds)
    assert any(kind.is_fallback for kind in kinds)
    for words, found in known.by_hand.items():
        assert len(words) > 1 or words[0] not in known.plain, f"{words} can never be read"
        assert not found[0].is_fallback


def test_its_data_are_small_and_name_their_source():
    text = (files("sloop_ppl") / "data/kinds/osm.json").read_text("utf-8")
    data = json.loads(text)
    notice = (files("sloop_ppl") / "data/kinds/NOTICE.md").read_text("utf-8")
    assert len(text.encode()) < 150_000
    assert f"version {data['version']}" in notice
    assert data["package"] in notice
    assert "Permission to use, copy, modify" in notice


def test_the_table_is_rebuilt_from_the_package(tmp_path):
    """A package of four presets: what is kept of names and terms, and the same bytes twice."""
    presets = {
        "amenity/bank": {"tags": {"amenity": "bank"}},
        "amenity/bus_station": {"tags": {"amenity": "bus_station"}},
        "amenity/school": {"tags": {"amenity": "school"}},
        "type/route": {"tags": {"type": "route"}},
    }
    spoken = {
        "amenity/bank": {"name": "Bank", "aliases": ["Credit Union"], "terms": ["trust", "kiosk"]},
        "amenity/bus_station": {"name": "Bus Station / Terminal", "terms": ["coach station"]},
        "amenity/school": {"name": "School Grounds"},
        "type/route": {"name": "Route"},
    }
    fields = {"cuisine": {"options": {"ice_cream": "Ice Cream"}}}
    english = {"en": {"presets": {"presets": spoken, "fields": fields}}}
    for name, data in (
        ("package.json", {"version": "1.2.3"}),
        ("dist/presets.json", presets),
        ("dist/translations/en.json", english),
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(data))
    sys.path.insert(0, str(ROOT / "tests" / "tools"))
    try:
        from build_kinds import kinds_file
    finally:
        sys.path.pop(0)
    text = kinds_file(tmp_path)
    built = json.loads(text)
    assert text == kinds_file(tmp_path)
    assert built["version"] == "1.2.3"
    assert built["cuisines"] == {"ice cream": "ice_cream"}
    assert built["kinds"] == [
        ["amenity=bank", ["bank", "credit union"], ["kiosk"]],
        ["amenity=bus_station", ["bus station", "bus terminal"], ["coach station"]],
        ["amenity=school", ["school"], []],
    ]


def ids(phrase, city, **how):
    return [city.landmarks[i].id for i in landmarks_of_kind(phrase, city, **how)]


@pytest.mark.parametrize(
    ("name", "phrase", "expected"),
    [
        ("cleveland", "restaurants", ["Hanabi", "KarlsInnoftheBarristers", "BluePointe"]),
        ("cleveland", "nightclub", ["Rumor", "Spirits", "VelvetDog"]),
        ("cleveland", "pub", ["Ivy", "BarleyHouse"]),
        ("cleveland", "liquor store", ["WineShop1"]),
        ("cleveland", "bank", []),
        ("cleveland", "alley", ["ServiceRoad1", "ServiceRoad2"]),
        ("denver", "alley", ["Alley1", "Alley2"]),
        ("denver", "bike rack", ["BicycleParking1", "BicycleParking2"]),
        ("denver", "bus stop", ["GrantStreetand12thAvenue"]),
        ("austin", "parking garage", ["LavacaPlaza", "ChaseTowerParkingGarage"]),
        ("austin", "bank", ["ChaseBankBldg"]),
        ("honolulu", "bus stop", ["BusStop2"]),
        ("honolulu", "cafe", ["Cafe1"]),
        ("honolulu", "street", ["SouthKingSt", "BethelSt", "MerchantSt", "Street1"]),
        ("washington_dc", "playground", ["Playground1"]),
        ("washington_dc", "car park", ["ParkingLot1", "ParkingLot2", "ParkingLot3", "ParkingPOI1"]),
        ("washington_dc", "zoo", []),
        ("washington_dc", "quickly", []),
    ],
)
def test_landmarks_of_a_kind_on_bundled_maps(name, phrase, expected):
    assert ids(phrase, sloop.load_map(name)) == expected


def test_own_kinds_are_all_landmarks_of_the_kind():
    for name in bundled_maps():
        city = sloop.load_map(name)
        for phrase in ("building", "street"):
            assert ids(phrase, city) == [m.id for m in city.of_kind(phrase)]
        assert set(ids("parking lot", city)) >= {m.id for m in city.of_kind("parking")}


@pytest.mark.parametrize(
    ("name", "phrase", "expected"),
    [
        ("washington_dc", "church", ["TheUnitedChurch"]),
        ("washington_dc", "apartment buildings", ["EmpireApartments", "StatesmanApartments"]),
        ("washington_dc", "café", ["CafeAria"]),
        ("honolulu", "theater", ["KumuKahuaTheatre"]),
        ("honolulu", "mall", []),  # Fort Street Mall is a street
        ("honolulu", "square", []),  # Pioneer Plaza is a building
        ("cleveland", "house", []),  # Barley House is a bar
    ],
)
def test_names_count_where_asked_for(name, phrase, expected):
    city = sloop.load_map(name)
    assert ids(phrase, city, by_name=True) == expected
    assert ids(phrase, city) == []


def own_map(*landmarks):
    grid = sloop.load_map("cleveland").grid
    point = shapely.Point(0, 0)
    return CityMap("own", grid, tuple(
        Landmark(f"L{i}", kind, point, name=f"Name {i}", properties=tags)
        for i, (kind, tags) in enumerate(landmarks)
    ))  # fmt: skip


def test_all_tags_must_hold_and_lists_of_values_hold_each():
    city = own_map(
        ("poi", {"amenity": "restaurant", "cuisine": "pizza;italian"}),
        ("poi", {"amenity": "restaurant", "cuisine": "thai"}),
        ("poi", {"amenity": "cafe", "cuisine": "italian"}),
        ("poi", {"shop": "no"}),
        ("building", {"amenity": "fast_food", "cuisine": "Italian"}),
    )
    assert ids("italian restaurant", city) == ["L0", "L4"]
    assert ids("italian place", city) == ["L0", "L2", "L4"]
    assert ids("shop", city) == []


def test_a_fallback_counts_only_where_nothing_is_surer():
    lawn, park, bare = ("park", {"landuse": "grass"}), ("park", {"leisure": "park"}), ("park", {})
    assert ids("park", own_map(lawn, park, bare)) == ["L1"]
    assert ids("park", own_map(lawn, bare)) == ["L1"]
    assert ids("park", own_map(lawn)) == []


def test_worship_without_a_religion_is_a_church_and_another_is_none():
    worship = {"amenity": "place_of_worship"}
    city = own_map(("poi", worship), ("poi", worship | {"religion": "muslim"}),
                   ("poi", worship | {"religion": "christian"}))  # fmt: skip
    assert ids("church", city) == ["L2", "L0"]
    assert ids("mosque", city) == ["L1"]
    assert ids("place of worship", city) == ["L0", "L1", "L2"]


def test_the_first_import_loads_neither_torch_nor_scipy(tmp_path):
    code = (
        "import sys\n"
        "from sloop_ppl.language.kinds import kinds_of\n"
        "kinds_of('bank')\n"
        "print(sorted({'torch', 'scipy', 'spacy'} & set(sys.modules)))\n"
    )
    assert run_python(code, tmp_path).strip() == "[]"

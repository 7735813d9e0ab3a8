"""Check parsed map files against the JSON schema that ships with the package."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

import jsonschema_rs

from sloop_ppl.errors import MapError

__all__ = ["check_schema", "fault", "map_schema"]

# Letters of a value that an error message shows.
_SHOWN = 40


@cache
def map_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 7) of the map format, as `data/map.schema.json` holds it."""
    text = (files("sloop_ppl") / "data" / "map.schema.json").read_text(encoding="utf-8")
    schema: dict[str, Any] = json.loads(text)
    return schema


def check_schema(data: Any, source: str) -> None:
    """Check parsed GeoJSON against the schema of the map format.

    Parameters
    ----------
    source
        What to call the input in messages.

    Raises
    ------
    MapError
        At the first thing that does not follow the schema; one line that names the feature, the
        field, what was found and what was expected.
    """
    try:
        _validator().validate(data)
    except jsonschema_rs.ValidationError as error:
        raise _as_map_error(error, data, source) from None
    except ValueError as error:
        raise MapError(f"{source}: is not JSON: {error}") from None


def fault(source: str, feature: str, name: str, what: str) -> MapError:
    """Return the error that a field of a feature is at fault."""
    return MapError(
        f"{source}: feature {feature!r}: field '{name}' {what}", feature=feature, field=name
    )


@cache
def _validator() -> jsonschema_rs.Validator:
    return jsonschema_rs.validator_for(map_schema())


def _as_map_error(error: jsonschema_rs.ValidationError, data: Any, source: str) -> MapError:
    path, rule = list(error.instance_path), list(error.schema_path)
    broken = str(rule[-1])
    if not path and broken == "type":
        path = ["type"]
    missing = None
    if broken == "required":
        found = _follow(data, path)
        missing = next(str(n) for n in _follow(map_schema(), rule) if n not in found)
        path = [*path, missing]
    # The one anyOf of the schema: half_extent_m or extent_m.
    if broken == "anyOf":
        path, missing = ["half_extent_m"], "half_extent_m"
    expected = _expectation(rule, missing)
    if missing == "centre" and ("elements" in data or _tagged(data)):
        return MapError(
            f"{source}: is OpenStreetMap data and no map yet; make a map of it with "
            "`sloop map import FILE --all --out MAP.geojson`"
        )
    fact = "is missing" if missing else f"is {_shown(_follow(data, path))}"
    return _named(data, path, source, f"{fact}; expected {expected}")


def _tagged(data: Any) -> bool:
    """Tell whether the first feature is one of OpenStreetMap: it has tags, and no kind."""
    first = _follow(data, ["features", 0, "properties"])
    return (
        isinstance(first, Mapping)
        and "kind" not in first
        and bool(
            {"@id", "full_id", "osm_id", "tags", "building", "highway", "amenity"} & set(first)
        )
    )


def _named(data: Any, path: Sequence[str | int], source: str, what: str) -> MapError:
    """Return the error with the feature and the field that a path into the data leads to."""
    if path[0] != "features" or len(path) == 1:
        name = ".".join(str(step) for step in path if isinstance(step, str))
        return MapError(f"{source}: field '{name}' {what}", field=name)
    index = path[1]
    properties = _follow(data, ["features", index, "properties"])
    known = properties.get("id") if isinstance(properties, Mapping) else None
    feature = known if isinstance(known, str) and known else f"number {index}"
    steps = [step for step in path[2:] if isinstance(step, str)]
    name = "properties" if not steps else steps[0]
    if name == "properties" and len(steps) > 1:
        name = steps[1]
    return fault(source, feature, name, what)


def _expectation(rule: Sequence[str | int], missing: str | None) -> str:
    """Return the description of the innermost part of the schema that was broken."""
    if missing == "half_extent_m":
        return "a number of metres (or 'extent_m': [west, south, east, north])"
    part = _follow(map_schema(), rule[:-1])
    if missing is not None:
        part = part["properties"][missing]
        if "$ref" in part:
            part = map_schema()["definitions"][part["$ref"].rpartition("/")[2]]
    return str(part["description"])


def _follow(data: Any, path: Sequence[str | int]) -> Any:
    for step in path:
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _shown(value: Any) -> str:
    """Return a value as one short line."""
    if isinstance(value, Mapping):
        return "an object"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}" if value else "an empty list"
    try:
        text = repr(value)
    except ValueError:  # an integer of thousands of digits
        text = "a very large number"
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"

"""Models by listed name, and their numbers that a page may change, within bounds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass
from typing import Any

from sloop_ppl.bridge._catalogue import names_of
from sloop_ppl.bridge._requests import model_of
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models import ObservationModel, with_parameters
from sloop_ppl.models.likelihoods import parameters_of

__all__ = ["listed_model", "listed_name", "parameters_payload", "with_bounded_parameters"]

_SHARES = {
    "lapse": "probability that a phrase is wrong",
    "own_lapse": "probability that a phrase of one's own place is wrong",
    "temper": "0 counts all phrases in full, 1 their average",
    "denial": "how far a denied phrase is believed",
    "unreliable": "probability that nothing a speaker says means anything",
}
"""Numbers of a model from 0 to 1."""

_SWITCHES = {
    "joint_grounds": "a relation to several places has a meaning of its own",
    "heed_distance": "distances that are said count",
    "sum_readings": "all ways to read the text count, not the likeliest alone",
    "sum_grounds": "all places that may be meant count, not the likeliest alone",
}

_FRAMES = {
    "kappa": "how near fronts lie to the predicted ones",
    "lapse": "probability that a predicted front says nothing",
    "absolute": "probability that left and right are those of the map",
    "absolute_kappa": "how near they lie to those of the map",
}

_DEAF = ("uniform", "keyword", "informed")
"""Components in which no number of the model counts."""


@dataclass(frozen=True)
class _Parameter:
    """One number or switch, with the range the page offers; `high` is None for a switch."""

    section: str
    name: str
    value: float | bool
    low: float | None
    high: float | None
    unit: str
    meaning: str


def listed_name(what: str, kind: str, name: str | None) -> str | None:
    """Return a name that is listed; never a file, which a page must not choose.

    Raises
    ------
    UnknownName
        When it is not listed.
    """
    if name is not None and name not in names_of(what):
        raise UnknownName(kind, name, names_of(what))
    return name


def listed_model(name: str, variant: str, frames: str | None = None) -> ObservationModel:
    """Return a model of `sloop list models`.

    Raises
    ------
    UnknownName
        When model or variant is not listed.
    """
    listed_name("models", "model", name)
    if variant not in ("published", "paper"):
        raise UnknownName("variant", variant, ("published", "paper"))
    return model_of(name, variant, frames)


def parameters_payload(model: ObservationModel) -> list[dict[str, Any]]:
    """Return the numbers of a model that may be changed, with their ranges and meanings."""
    return [asdict(parameter) for parameter in _parameters(model)]


def with_bounded_parameters(
    model: ObservationModel, values: Mapping[str, Mapping[str, float | bool]]
) -> ObservationModel:
    """Return a model with some numbers changed, each within the range that the page offers.

    Raises
    ------
    UnknownName
        For a section or number that the page does not offer.
    InputError
        For a number out of its range.
    """
    if not values:
        return model
    known = {(p.section, p.name): p for p in _parameters(model)}
    for section, numbers in values.items():
        for name, value in numbers.items():
            parameter = known.get((section, name))
            if parameter is None:
                names = [f"{s}.{n}" for s, n in known]
                raise UnknownName(f"parameter of model {model.name}", f"{section}.{name}", names)
            low, high = parameter.low, parameter.high
            if low is None or high is None or isinstance(value, bool):
                continue  # a switch, or a mistake that `with_parameters` finds
            if not low <= value <= high:
                raise InputError(
                    f"Parameter '{name}' is {value:g}; expected {low:.4g} to {high:.4g}"
                )
    return with_parameters(model, values)


def _parameters(model: ObservationModel) -> Iterator[_Parameter]:
    parts = model.components
    if len(parts) > 1:
        for part in parts:
            yield _Parameter(
                "weights", part.name, part.weight, 0.001, 1.0, "1", "weight of this component"
            )
    if all(part.name in _DEAF for part in parts):
        return
    for declared in parameters_of(model.likelihood):
        value = float(getattr(model.likelihood, declared.name))
        low, high = _offered(value, declared.low, declared.high)
        yield _Parameter(
            "likelihood", declared.name, value, low, high, declared.unit, declared.meaning
        )
    prior: Any = model.frame_prior
    for field in fields(prior) if is_dataclass(prior) else ():
        value = getattr(prior, field.name)
        if field.name in _FRAMES and math.isfinite(value):
            low, high = _offered(
                value, 0.0, math.inf if field.name.endswith("kappa") else 1.0, closed=True
            )
            yield _Parameter("frames", field.name, value, low, high, "1", _FRAMES[field.name])
    for name, meaning in _SHARES.items():
        number = getattr(model, name)
        if number is not None:
            highest = 1.0 if name in ("temper", "denial") else 0.99
            yield _Parameter("model", name, number, 0.0, highest, "1", meaning)
    for name, meaning in _SWITCHES.items():
        yield _Parameter("model", name, getattr(model, name), None, None, "1", meaning)


def _offered(value: float, low: float, high: float, *, closed: bool = False) -> tuple[float, float]:
    """Return the range offered: a tenth to four times the value, or all of a finite range."""
    if math.isinf(high):
        return low + (value - low) / 10, 4 * value
    edge = 0.0 if closed else (high - low) / 100
    return low + edge, high - edge

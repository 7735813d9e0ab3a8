"""Change the numbers of a model by name, from a mapping or a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from sloop_ppl._foreign import ForeignFault, parse_json, parse_toml, read_text
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models.likelihoods import with_values
from sloop_ppl.models.presets import ObservationModel

__all__ = ["load_parameters", "with_parameters"]

_MODEL_NUMBERS = ("lapse", "own_lapse", "temper", "error_m", "denial", "unreliable")
_MODEL_SWITCHES = (
    *("joint_grounds", "heed_distance", "shared_frames"),
    *("sum_readings", "sum_grounds"),
)
_SHARES = ("lapse", "own_lapse", "absolute")


def load_parameters(path: str | Path) -> dict[str, dict[str, Any]]:
    """Read parameters from a file.

    Parameters
    ----------
    path
        A ``.toml`` file of the sections that `with_parameters` takes, or a ``.json`` file of them,
        by themselves or as its member ``parameters``.

    Raises
    ------
    InputError
        When the file does not exist, or is no TOML or JSON of sections.
    """
    file = Path(path)
    text = read_text(file, "Parameter file")
    kind = "JSON" if file.suffix == ".json" else "TOML"
    try:
        payload: Any = parse_json(text) if kind == "JSON" else parse_toml(text)
    except ForeignFault as error:
        raise InputError(f"Parameter file '{path}' is no {kind}: {error}") from error
    if isinstance(payload, Mapping) and isinstance(payload.get("parameters"), Mapping):
        payload = payload["parameters"]
    if not isinstance(payload, Mapping) or not all(
        isinstance(s, Mapping) for s in payload.values()
    ):
        raise InputError(
            f"Parameter file '{path}' has numbers outside a section; put them under one of "
            f"{', '.join(f'[{name}]' for name in _SECTIONS)}"
        )
    return {name: dict(section) for name, section in payload.items()}


def with_parameters(
    model: ObservationModel, values: Mapping[str, Mapping[str, Any]]
) -> ObservationModel:
    """Return a model with some of its numbers changed.

    Parameters
    ----------
    model
        The model.
    values
        Section -> name -> value. Sections are ``likelihood`` (what it declares as ``parameters``),
        ``model`` (lapse, temper, error_m and the switches), ``frames`` (the numbers of the frame
        prior) and ``weights`` (prior weight by component).

    Raises
    ------
    UnknownName
        For a section or parameter there is none of; it lists those there are.
    InputError
        For a value of the wrong type or out of range.

    Examples
    --------
    >>> from sloop_ppl.models import preset
    >>> numbers = {"frames": {"kappa": 2}, "weights": {"no-frame": 0.2}}
    >>> tuned = with_parameters(preset("bayes"), numbers)
    >>> tuned.frame_prior.kappa
    2.0
    """
    for section, numbers in values.items():
        if section not in _SECTIONS:
            raise UnknownName("section of parameters", section, _SECTIONS)
        model = _SECTIONS[section](model, numbers)
    return model


def _likelihood(model: ObservationModel, numbers: Mapping[str, Any]) -> ObservationModel:
    return replace(model, likelihood=with_values(model.likelihood, numbers))


def _model(model: ObservationModel, numbers: Mapping[str, Any]) -> ObservationModel:
    changed: dict[str, Any] = {}
    for name, value in numbers.items():
        if name in _MODEL_SWITCHES:
            if not isinstance(value, bool):
                raise InputError(f"Switch '{name}' is {value!r}; expected true or false")
            changed[name] = value
        elif name in _MODEL_NUMBERS:
            changed[name] = _number(name, value)
        else:
            raise UnknownName("parameter of the model", name, _MODEL_NUMBERS + _MODEL_SWITCHES)
    return replace(model, **changed)


def _frames(model: ObservationModel, numbers: Mapping[str, Any]) -> ObservationModel:
    prior: Any = model.frame_prior
    known: list[str] = []
    if is_dataclass(prior):
        known = [f.name for f in fields(prior) if isinstance(getattr(prior, f.name), int | float)]
    changed = {}
    for name, value in numbers.items():
        if name not in known:
            raise UnknownName(f"parameter of {type(prior).__name__}", name, known)
        number = _number(name, value, finite=False)  # a kappa of infinity is one certain front
        allowed, range_text = _range_of(name)
        if not allowed(number):
            raise InputError(
                f"Parameter '{name}' of frames is {number:g}; expected it {range_text}"
            )
        changed[name] = number
    return replace(model, frame_prior=replace(prior, **changed))


def _range_of(name: str) -> tuple[Callable[[float], bool], str]:
    """Return what a number of a frame prior may be, as a test and in words."""
    if name in _SHARES:
        return lambda number: 0 <= number <= 1, "from 0 to 1"
    if name.endswith("_rad"):
        return math.isfinite, "finite"
    return lambda number: number > 0, "more than 0"


def _weights(model: ObservationModel, numbers: Mapping[str, Any]) -> ObservationModel:
    known = [part.name for part in model.components]
    for name in numbers:
        if name not in known:
            raise UnknownName(f"component of model {model.name}", name, known)
    components = tuple(
        replace(part, weight=_number(part.name, numbers[part.name]))
        if part.name in numbers
        else part
        for part in model.components
    )
    return replace(model, components=components)


def _number(name: str, value: Any, *, finite: bool = True) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"Parameter '{name}' is {value!r}; expected a number")
    if value != value:
        raise InputError(f"Parameter '{name}' is NaN; expected a number")
    if not -1e300 <= value <= 1e300 and (finite or isinstance(value, int)):
        raise InputError(f"Parameter '{name}' is infinite; expected a finite number")
    return float(value)


_SECTIONS: dict[str, Callable[[ObservationModel, Mapping[str, Any]], ObservationModel]] = {
    "likelihood": _likelihood,
    "model": _model,
    "frames": _frames,
    "weights": _weights,
}

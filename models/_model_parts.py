"""Write a model as plain data of registered parts and numbers, and make it again from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass, replace
from typing import Annotated, Any, get_type_hints

from msgspec import Meta, Struct, defstruct

from sloop_ppl._records import Fault, Text, checked
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models._guard import GuardedLikelihood
from sloop_ppl.models.components import COMBINATIONS, Component
from sloop_ppl.models.frames import FRAME_PREDICTORS, FRAME_PRIORS, FramePrior
from sloop_ppl.models.interventions import GivenFrames
from sloop_ppl.models.latents import Latent
from sloop_ppl.models.likelihoods import (
    LIKELIHOODS,
    RelationLikelihood,
    parameters_of,
    with_values,
)
from sloop_ppl.models.presets import PRESETS, ObservationModel, preset
from sloop_ppl.models.tuning import with_parameters
from sloop_ppl.models.user import load_model
from sloop_ppl.registry import Registry
from sloop_ppl.user_file import is_user_file

__all__ = ["model_from_parts", "parts_of"]

_NESTED = ("components", "likelihood", "frame_prior", "latents")
_PLAIN = tuple(field.name for field in fields(ObservationModel) if field.name not in _NESTED)

Real = Annotated[float, Meta(description="a number")]  # also infinity, as a concentration
Flag = Annotated[bool, Meta(description="true or false")]
Reals = Annotated[dict[str, Real], Meta(description="an object of numbers")]


class _LikelihoodRecord(Struct, frozen=True):
    name: Text
    parameters: Reals


class _FrameRecord(Struct, frozen=True):
    name: Text
    numbers: Reals
    predictor: Text | None


class _ComponentRecord(Struct, frozen=True):
    name: Text
    weight: Real
    combine: Text
    keep_frames: Flag
    read_as: Text | None
    cut: Flag


class _LatentRecord(Struct, frozen=True):
    name: Text
    support: Annotated[list[Any], Meta(description="a list of values")]
    prior: Annotated[list[Real], Meta(description="a list of numbers")]
    per: Text


def _model_record() -> type[Struct]:
    """Return the record of a model, of whose numbers `ObservationModel` has the types."""
    known: dict[Any, Any] = {str: Text, float: Real, bool: Flag, float | None: Real | None}
    hints = get_type_hints(ObservationModel)
    plain = [(name, known.get(hints[name], Text)) for name in _PLAIN]
    latents = Annotated[list[_LatentRecord], Meta(description="a list")] | Text
    parts = [
        ("components", Annotated[list[_ComponentRecord], Meta(description="a list")]),
        ("likelihood", _LikelihoodRecord),
        ("frame_prior", _FrameRecord),
        ("latents", latents),
    ]
    return defstruct("ModelRecord", [*plain, *parts], frozen=True)


def parts_of(model: ObservationModel) -> dict[str, Any]:
    """Return a model as data that JSON can hold.

    Parameters
    ----------
    model
        A model whose likelihood, frame prior and frame predictor are registered ones with other
        numbers, or one that is itself registered under its name.

    Raises
    ------
    InputError
        When some part of it is neither; it names the part.

    Examples
    --------
    >>> from sloop_ppl.models import preset
    >>> parts_of(preset("sloop"))["likelihood"]["name"]
    'gaussian-clipped'
    """
    plain = {name: getattr(model, name) for name in _PLAIN}
    try:
        return {
            **plain,
            "latents": _latent_parts(model),
            "components": [asdict(component) for component in model.components],
            "likelihood": _likelihood_parts(model),
            "frame_prior": _frame_parts(model),
        }
    except InputError:
        if model.name in PRESETS and preset(model.name, model.variant) == model:
            return {"name": model.name, "variant": model.variant}
        raise


def model_from_parts(parts: Mapping[str, Any]) -> ObservationModel:
    """Return the model that `parts_of` wrote.

    Parameters
    ----------
    parts
        What `parts_of` gave; only ``name`` and ``variant`` for a model registered as a whole.

    Raises
    ------
    UnknownName
        For a part, parameter or registered name there is none of; it lists those there are.
    InputError
        For a value out of its range, or something missing.
    """
    if set(parts) == {"name", "variant"}:
        return preset(str(parts["name"]), str(parts["variant"]))
    _check_names("part of a model", parts, (*_PLAIN, *_NESTED))
    try:
        checked(parts, _model_record())
    except Fault as fault:
        raise InputError(f"A model's {fault}") from fault
    frame_prior, likelihood = parts["frame_prior"], parts["likelihood"]
    _check_names("part of a likelihood", likelihood, ("name", "parameters"))
    _check_names("part of a frame prior", frame_prior, ("name", "numbers", "predictor"))
    made = ObservationModel(
        **{name: parts[name] for name in _PLAIN},
        components=tuple(_component(part) for part in parts["components"]),
        likelihood=with_values(_likelihood(likelihood["name"]), likelihood["parameters"]),
        frame_prior=_frame_prior(frame_prior),
        latents=_latents(parts["latents"]),
    )
    made = with_parameters(made, {"frames": frame_prior["numbers"]})
    return preset(made, made.variant)


def _latent_parts(model: ObservationModel) -> list[dict[str, Any]] | str:
    """Return the declared latents as data, or where they are found again."""
    if all(latent.is_data for latent in model.latents):
        names = ("name", "support", "prior", "per")
        return [{name: getattr(latent, name) for name in names} for latent in model.latents]
    if isinstance(model.likelihood, GuardedLikelihood) and model.likelihood.spec:
        return model.likelihood.spec
    raise InputError(
        f"Model '{model.name}' declares latents with functions, which cannot be written; put it in "
        "a file and use FILE.py:NAME, register it in sloop_ppl.models.PRESETS under a name of its "
        "own, or write the cells alone: to_geojson, on the command line --export"
    )


def _latents(payload: Sequence[Mapping[str, Any]] | str) -> tuple[Latent, ...]:
    if isinstance(payload, str):
        return load_model(payload).latents
    return tuple(
        Latent(one["name"], tuple(one["support"]), tuple(one["prior"]), per=one["per"])
        for one in payload
    )


def _likelihood_parts(model: ObservationModel) -> dict[str, Any]:
    likelihood = model.likelihood
    spec = ""
    if isinstance(likelihood, GuardedLikelihood):
        spec = likelihood.spec
        likelihood = likelihood.inner
    values = {p.name: float(getattr(likelihood, p.name)) for p in parameters_of(likelihood)}

    if spec:
        return {"name": spec, "parameters": values}

    def same(entry: RelationLikelihood) -> bool:
        return type(entry) is type(likelihood) and with_values(entry, values) == likelihood

    return {"name": _registered(LIKELIHOODS, same, "likelihood", model), "parameters": values}


def _likelihood(name: str) -> RelationLikelihood:
    """Return a registered likelihood, or that of a user's file."""
    return load_model(name).likelihood if is_user_file(name) else LIKELIHOODS[name]


def _frame_parts(model: ObservationModel) -> dict[str, Any]:
    prior: Any = model.frame_prior
    if isinstance(prior, GivenFrames):
        raise InputError(
            f"The frame prior of model '{model.name}' is none of the registered ones: its fronts "
            "were set with do=, which is not saved; save the posterior inferred without it, or "
            "write the cells alone: to_geojson"
        )
    numbers = _numbers(prior)
    predictor = getattr(prior, "predictor", None)
    named = None
    if predictor is not None:
        named = _registered(
            FRAME_PREDICTORS,
            lambda entry: entry is predictor or entry == predictor,
            "frame predictor",
            model,
        )

    def same(entry: Any) -> bool:
        return type(entry) is type(prior) and _changed(entry, numbers, predictor) == prior

    name = _registered(FRAME_PRIORS, same, "frame prior", model)
    return {"name": name, "numbers": numbers, "predictor": named}


def _registered(registry: Registry[Any], same: Any, kind: str, model: ObservationModel) -> str:
    """Return the name of the first entry that is the same, but for its numbers."""
    for name, entry in registry.items():
        if same(entry):
            return name
    raise InputError(
        f"The {kind} of model '{model.name}' is none of the registered ones with other numbers, so "
        "what is saved could not be read again; register it, or the whole model in "
        "sloop_ppl.models.PRESETS, under a name of its own, or write the cells alone: to_geojson, "
        "on the command line --export"
    )


def _component(record: Mapping[str, Any]) -> Component:
    _check_names("part of a component", record, tuple(field.name for field in fields(Component)))
    return replace(Component(**record), combine=_known(COMBINATIONS, record["combine"]))


def _known(registry: Registry[Any], name: str) -> str:
    _ = registry[name]  # raises for a name there is none of
    return name


def _frame_prior(record: Mapping[str, Any]) -> FramePrior:
    entry: Any = FRAME_PRIORS[record["name"]]
    _check_names(
        f"number of frame prior {record['name']}", record["numbers"], tuple(_numbers(entry))
    )
    predictor = None if record["predictor"] is None else FRAME_PREDICTORS[record["predictor"]]
    made: FramePrior = _changed(entry, {}, predictor)
    return made


def _numbers(prior: Any) -> dict[str, float]:
    if not is_dataclass(prior) or isinstance(prior, type):
        return {}
    named = {field.name: getattr(prior, field.name) for field in fields(prior)}
    return {name: float(value) for name, value in named.items() if isinstance(value, int | float)}


def _changed(prior: Any, numbers: Mapping[str, float], predictor: Any) -> Any:
    changes = dict(numbers) if predictor is None else {**numbers, "predictor": predictor}
    return replace(prior, **changes) if changes else prior


def _check_names(kind: str, record: Mapping[str, Any], expected: tuple[str, ...]) -> None:
    for name in record:
        if name not in expected:
            raise UnknownName(kind, str(name), expected)
    lacking = [name for name in expected if name not in record]
    if lacking:
        raise InputError(f"A {kind} is missing: {', '.join(lacking)}; save it again")

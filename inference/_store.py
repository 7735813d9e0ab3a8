"""Keep a posterior in a netCDF file that carries its map, its descriptions and its tables.

Shape legend: V values of each latent that phrases share; K components.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import shapely
from numpy.typing import NDArray

from sloop_ppl._cell_axes import by_coordinate
from sloop_ppl._foreign import parse_json
from sloop_ppl._records import Text, checked
from sloop_ppl.errors import InputError
from sloop_ppl.inference.answers import AnswerFactor
from sloop_ppl.inference.engines import ENGINES, Engine
from sloop_ppl.inference.factors import DescriptionFactor
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap, SearchArea, from_geojson, search_area, to_geojson
from sloop_ppl.models import (
    ObservationModel,
    ground_description,
    ground_target_relations,
    program_data,
)
from sloop_ppl.models._model_parts import model_from_parts, parts_of
from sloop_ppl.models._netcdf import read_netcdf
from sloop_ppl.models.program import pair_kernels
from sloop_ppl.outputs import check_output, written_whole

if TYPE_CHECKING:
    import xarray

__all__ = ["StoredPosterior", "load_parts", "save_parts", "to_dataset"]

Table = NDArray[np.float64]

_TITLE = "sloop_ppl posterior"
_FORMAT = 4
_SECTIONS = {"cells": 1, "descriptions": 1, "engine": 1, "factors": 1, "map": 1, "model": 1}
"""Section of a file -> its version. A reader refuses versions it does not know, section by
section, and passes over sections it does not know, so that a later latent needs no new format."""

_OPTIONAL = {"answers": 1, "area": 1, "digest": 1}
"""Sections that a file may lack: without an area it is the map; earlier files have no digest."""

_DIGESTED = (
    *("belief", "log_prior", "log_sensed", "log_factor"),
    *("entry_target", "entry_description", "target", "component", "x", "y"),
)


_OPTIONAL_TEXTS = ("tables_digest", "area_wkt", "answers")
_Places = tuple[tuple[float, float], ...]


class _Attributes(msgspec.Struct, frozen=True):
    """The texts of a file, most of them JSON."""

    map_geojson: Text
    model_parts: Text
    descriptions: Text
    truths: Text
    engine: Text
    engine_options: Text
    tables_digest: Text | None = None
    area_wkt: Text | None = None
    answers: Text = "[]"


@dataclass(frozen=True, eq=False)
class StoredPosterior:
    """What a posterior is made of, and what a file holds of it.

    Parameters
    ----------
    city, model, method
        The map, the observation model and the engine.
    log_prior, log_sensed
        Target -> log prior over cells, and log likelihood of what was sensed, shape (S,) each.
    factors
        The descriptions, weighed.
    area
        Where targets are searched for; the whole map when None.
    answers
        What was answered to questions.
    """

    city: CityMap
    model: ObservationModel
    method: Engine
    log_prior: Mapping[str, Table]
    factors: tuple[DescriptionFactor, ...]
    log_sensed: Mapping[str, Table]
    area: SearchArea | None = None
    answers: tuple[AnswerFactor, ...] = ()


def to_dataset(
    parts: StoredPosterior, beliefs: Mapping[str, Table], log_evidence: float
) -> xarray.Dataset:
    """Return a posterior as a Dataset.

    Variables are ``belief``, ``log_prior``, ``log_sensed`` (target, y, x) and ``log_factor``
    (entry, setting, component, y, x), one entry for each description of each target and one
    setting for each joint value of the latents it shares; coordinates x and y are cell centres in
    metres, y from the south.
    """
    import xarray

    grid = parts.city.grid
    targets = list(parts.log_prior)
    entries = [(t, d) for t in targets for d, f in enumerate(parts.factors) if t in f.log_factors]

    def over_cells(tables: Mapping[str, Table]) -> Table:
        return np.stack([tables[t].reshape(grid.shape) for t in targets])

    names = [component.name for component in parts.model.components]
    settings = max((_settings(parts.factors[d]) for _, d in entries), default=1)
    factors = np.full((len(entries), settings, len(names), *grid.shape), np.nan)
    for entry, (target, d) in enumerate(entries):
        table = parts.factors[d].log_factors[target]
        rows = table.reshape(-1, len(names), *grid.shape)
        factors[entry, : len(rows)] = rows
    cells = ("y", "x")
    sections = {**_SECTIONS, "digest": 1, **({"area": 1} if parts.area else {})}
    sections |= {"answers": 1} if parts.answers else {}
    made = xarray.Dataset(
        {
            "belief": (("target", *cells), over_cells(beliefs)),
            "log_prior": (("target", *cells), over_cells(parts.log_prior)),
            "log_sensed": (("target", *cells), over_cells(parts.log_sensed)),
            "log_factor": (("entry", "setting", "component", *cells), factors),
            "entry_target": ("entry", np.array([targets.index(t) for t, _ in entries], dtype=int)),
            "entry_description": ("entry", np.array([d for _, d in entries], dtype=int)),
        },
        coords={
            "target": targets,
            "component": names,
            "y": ("y", grid.y_m, {"units": "m", "long_name": "north of the map's centre"}),
            "x": ("x", grid.x_m, {"units": "m", "long_name": "east of the map's centre"}),
        },
        attrs={
            "title": _TITLE,
            "format": _FORMAT,
            "sections": json.dumps(sections),
            "map": parts.city.name,
            "map_digest": parts.city.digest,
            "model": parts.model.name,
            "variant": parts.model.variant,
            "engine": parts.method.name,
            "log_evidence": log_evidence,
            "descriptions": json.dumps(
                [
                    [_plain(asdict(description)) for description in factor.descriptions]
                    for factor in parts.factors
                ]
            ),
            "truths": json.dumps([f.data.truths for f in parts.factors]),
            "map_geojson": json.dumps(to_geojson(parts.city)),
            **({"area_wkt": parts.area.polygon.wkt} if parts.area else {}),
            **({"answers": _answers_json(parts.answers)} if parts.answers else {}),
        },
    )
    return made.assign_attrs(tables_digest=tables_digest(made))


def tables_digest(data: xarray.Dataset) -> str:
    """Return a SHA-256 of the tables of a posterior in their own order, in hexadecimal."""
    known = hashlib.sha256()
    for name in _DIGESTED:
        array = data[name]
        values = array.values
        if values.dtype.kind in "OUST":
            written = json.dumps([str(value) for value in values.ravel()]).encode()
        else:
            kind = "<f8" if values.dtype.kind == "f" else "<i8"
            written = np.ascontiguousarray(values, dtype=kind).tobytes()
        known.update(json.dumps([name, [str(d) for d in array.dims], values.shape]).encode())
        known.update(written)
    return known.hexdigest()


def save_parts(
    parts: StoredPosterior,
    beliefs: Mapping[str, Table],
    log_evidence: float,
    path: str | Path,
) -> None:
    """Write a posterior to a ``.nc`` file, whole or not at all.

    Raises
    ------
    InputError
        When the model is made of parts that are not registered, or the engine is not.
    OutputError
        When the file cannot be written.

    Notes
    -----
    The model goes with it as :func:`sloop_ppl.models._model_parts.parts_of` writes it,
    numbers and all, so that a model with parameters of its own, or whose defaults change later, is
    read as it was.
    """
    target = check_output(path, (".nc",))
    method = parts.method
    if method.name not in ENGINES or type(ENGINES[method.name]) is not type(method):
        raise InputError(
            f"Engine '{method.name}' is not registered, so the file could not be read again; "
            "register it first: sloop_ppl.inference.ENGINES.add(name, engine)"
        )
    written = {
        "model_parts": json.dumps(parts_of(parts.model)),
        "engine_options": json.dumps(_options(method)),
    }
    with written_whole(target) as temporary:
        dataset = to_dataset(parts, beliefs, log_evidence).assign_attrs(written)
        dataset.to_netcdf(temporary, engine="h5netcdf")


def load_parts(path: str | Path) -> StoredPosterior:
    """Read what a ``.nc`` file holds of a posterior.

    Raises
    ------
    InputError
        When the file is no saved posterior, or one of another version; it says what to do.
    """
    data = read_netcdf(path, "Posterior")
    if data.attrs.get("title") != _TITLE:
        raise InputError(f"File '{path}' is not a posterior saved by sloop_ppl")
    if data.attrs.get("format") != _FORMAT:
        texts = _texts(data.attrs.get("descriptions"))
        again = f" from {'; '.join(repr(text) for text in texts)}" if any(texts) else ""
        raise InputError(
            f"Posterior '{path}' has format {data.attrs.get('format')}; expected {_FORMAT}; "
            f"infer it again with this version{again}"
        )
    try:
        sections = parse_json(data.attrs["sections"])
        _check_sections(sections)
        return _from_dataset(data, "digest" in sections, "answers" in sections)
    except KeyError as error:
        raise InputError(f"Posterior '{path}' lacks {error}; infer it again") from error
    except Exception as error:  # whatever a damaged part makes its reader raise
        message = " ".join(str(error).split())[:400] or type(error).__name__
        raise InputError(f"Posterior '{path}' cannot be read: {message}") from error


def _texts(written: Any) -> list[str]:
    """Return what the descriptions of a file of another format say, as far as it can be read."""
    try:
        known = json.loads(written)
    except (TypeError, ValueError):
        return []
    records = [d for d in known if isinstance(d, dict)] if isinstance(known, list) else []
    return [str(d.get("text", "")) for d in records]


def _check_sections(found: Any) -> None:
    if not isinstance(found, dict):
        raise InputError(f"its list of sections is {found!r}; expected names with versions")
    for name, version in (_SECTIONS | {n: v for n, v in _OPTIONAL.items() if n in found}).items():
        if found[name] != version:
            raise InputError(
                f"its section '{name}' has version {found[name]}; expected {version}; read it with "
                "the version of sloop_ppl that wrote it, or infer it again"
            )


def _from_dataset(data: xarray.Dataset, has_digest: bool, has_answers: bool) -> StoredPosterior:
    attributes = _attributes(data)
    city = from_geojson(parse_json(attributes.map_geojson))
    data = by_coordinate(data, "its tables have other cells than its map", city.grid)
    data = data.transpose("target", "entry", "setting", "component", "y", "x")
    model = model_from_parts(parse_json(attributes.model_parts, finite=False))
    targets = [str(t) for t in data["target"].values]
    names = tuple(str(name) for name in data["component"].values)
    if names != tuple(part.name for part in model.components):
        raise InputError(
            f"it holds {len(names)} components; its model has {len(model.components)}, or others"
        )
    if has_digest and attributes.tables_digest != tables_digest(data):
        raise InputError("its tables are not those that were saved; infer it again")
    written = _bounded(parse_json(attributes.descriptions))
    spoken = msgspec.convert(written, list[tuple[Description, ...]])
    truths = msgspec.convert(parse_json(attributes.truths), list[_Places | None])
    if len(truths) != len(spoken):
        raise InputError(
            f"it holds {len(truths)} lists of true places for {len(spoken)} utterances"
        )
    _check_tables(data, len(spoken))
    factors = []
    for d, descriptions in enumerate(spoken):
        grounded = ground_description(descriptions, city, model, targets)
        to_targets = ground_target_relations(descriptions, city, model, targets)
        ground = program_data(grounded, city, model, truths=truths[d], to_targets=to_targets)
        sizes = [len(latent.support) for latent in ground.shared]
        tables = {}
        for entry in np.flatnonzero(data["entry_description"].values == d):
            target = targets[int(data["entry_target"][entry])]
            if target not in ground.targets:
                raise InputError(f"its description {d + 1} says nothing of target '{target}'")
            table = data["log_factor"][int(entry), : math.prod(sizes)].values
            if np.isnan(table).any():
                raise InputError("its table log_factor holds NaN; expected log likelihoods")
            tables[target] = np.array(table.reshape(*sizes, len(names), -1), order="C")
        factors.append(DescriptionFactor(descriptions, ground, tables, pair_kernels(ground)))
    return StoredPosterior(
        city=city,
        model=model,
        method=_engine(attributes.engine, parse_json(attributes.engine_options)),
        log_prior={t: _cells(data["log_prior"], t) for t in targets},
        factors=tuple(factors),
        log_sensed={t: _cells(data["log_sensed"], t) for t in targets},
        area=_area(attributes.area_wkt, city),
        answers=_answers(attributes.answers) if has_answers else (),
    )


def _attributes(data: xarray.Dataset) -> _Attributes:
    """Return the texts of a file, checked to be texts; a KeyError names one that is missing."""
    required = [field.name for field in msgspec.structs.fields(_Attributes) if field.required]
    found = {name: data.attrs[name] for name in required}
    optional = {name: data.attrs[name] for name in _OPTIONAL_TEXTS if name in data.attrs}
    # netCDF gives a number as one of numpy's.
    plain = {name: getattr(v, "tolist", lambda v=v: v)() for name, v in (found | optional).items()}
    return checked(plain, _Attributes)


def _cells(table: xarray.DataArray, target: str) -> Table:
    """Return a target's table, shape (S,), in memory of its own: sums keep every bit."""
    return np.array(table.sel(target=target).values.reshape(-1), order="C")


def _check_tables(data: xarray.Dataset, n_descriptions: int) -> None:
    """Refuse tables that are no log weights, and entries of targets or descriptions not there."""
    for name in ("log_prior", "log_sensed"):
        top = data[name].values.max(axis=(-2, -1), initial=-np.inf)
        if np.isnan(data[name].values).any() or not np.isfinite(top).all():
            raise InputError(f"its table {name} holds NaN, infinity or a target that is nowhere")
    factors = data["log_factor"].values
    if np.isposinf(factors).any():
        raise InputError("its table log_factor holds infinity; expected log likelihoods")
    n_targets = data.sizes["target"]
    if len(set(map(str, data["target"].values))) < n_targets:
        raise InputError("it names a target twice; expected each once")
    for name, most in (("entry_target", n_targets), ("entry_description", n_descriptions)):
        index = data[name].values
        if index.dtype.kind not in "iu" or ((index < 0) | (index >= most)).any():
            raise InputError(f"its {name} names one that is not there; infer it again")


def _area(wkt: str | None, city: CityMap) -> SearchArea | None:
    if wkt is None:
        return None
    try:
        polygon = shapely.from_wkt(wkt)
    except shapely.errors.ShapelyError as error:
        raise InputError(f"its area is no polygon: {error}") from error
    return search_area(polygon, city.grid)


def _answers_json(answers: tuple[AnswerFactor, ...]) -> str:
    """Return answers as JSON; of a latent that is a cell the number of cells stands for all."""
    return json.dumps(
        [
            {
                "question": answer.question,
                "answer": answer.answer,
                "latents": list(answer.latents),
                "supports": [len(v) if isinstance(v, range) else list(v) for v in answer.supports],
                "likelihood": answer.likelihood.tolist(),
                "meant": answer.meant.tolist(),
                "text": answer.text,
                "description": answer.description and _plain(asdict(answer.description)),
            }
            for answer in answers
        ]
    )


class _AnswerRecord(msgspec.Struct, frozen=True):
    """An answer, as a file has it."""

    question: Text
    answer: Text
    latents: tuple[Text, ...]
    supports: list[int | list[Any]]
    likelihood: Any
    meant: Any
    text: str  # empty for an answer about a cell
    description: Description | None


def _answers(written: str) -> tuple[AnswerFactor, ...]:
    return tuple(
        AnswerFactor(
            question=record.question,
            answer=record.answer,
            latents=record.latents,
            supports=tuple(range(v) if isinstance(v, int) else tuple(v) for v in record.supports),
            likelihood=np.array(record.likelihood, dtype=np.float64),
            meant=np.array(record.meant, dtype=np.float64),
            text=record.text,
            description=record.description,
        )
        for record in checked(_bounded(parse_json(written)), list[_AnswerRecord])
    )


def _settings(factor: DescriptionFactor) -> int:
    return math.prod(len(latent.support) for latent in factor.data.shared)


def _options(engine: Any) -> dict[str, Any]:
    """Return the options of an engine that has them as fields."""
    if not is_dataclass(engine):
        return {}
    return {option.name: getattr(engine, option.name) for option in fields(engine)}


def _engine(name: str, options: Mapping[str, Any]) -> Engine:
    """Return the registered engine of a name with the options it had."""
    entry: Any = ENGINES[name]
    made: Engine = type(entry)(**options) if options else entry
    return made


def _plain(value: Any) -> Any:
    """Return a record with "at least" as no upper bound: files hold finite numbers only."""
    if isinstance(value, dict):
        return {k: _plain(None if v == math.inf else v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return value


def _bounded(value: Any) -> Any:
    """Return a record of a file with infinity where a distance has no upper bound."""
    if isinstance(value, dict):
        known = {k: _bounded(v) for k, v in value.items()}
        if known.get("high_m", 0.0) is None:
            known["high_m"] = math.inf
        return known
    return [_bounded(one) for one in value] if isinstance(value, list) else value

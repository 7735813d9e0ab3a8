"""Keep a posterior in a netCDF file that carries its map, its descriptions and its tables."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.posterior import Posterior
from sloop_ppl.inference.said import Said
from sloop_ppl.language import (
    Description,
    RelationSpans,
    SpatialRelation,
    TargetObject,
    Unresolved,
)
from sloop_ppl.maps import from_geojson, to_geojson
from sloop_ppl.models import ground_description, share_frames
from sloop_ppl.models._netcdf import read_netcdf
from sloop_ppl.models.parts import model_from_parts, parts_of
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["load_posterior", "save_posterior", "to_dataset"]

_FORMAT = 3


def to_dataset(posterior: Posterior) -> xarray.Dataset:
    """Return a posterior as a Dataset.

    Variables are ``belief``, ``log_prior``, ``log_sensed`` (target, y, x) and ``log_factor``
    (entry, setting, component, y, x), one entry for each description of each target and one
    setting for each joint setting of the frames it shares; coordinates x and y are cell centres in
    metres, y from the south.
    """
    grid = posterior.city.grid
    targets = list(posterior.targets)
    descriptions = posterior.descriptions
    entries = [(t, said) for t in targets for said in posterior.said[t]]

    def over_cells(tables: Mapping[str, np.ndarray]) -> np.ndarray:
        return np.stack([tables[t].reshape(grid.shape) for t in targets])

    names = [component.name for component in posterior.model.components]
    settings = max((said.shared.size for _, said in entries), default=1)
    factors = np.full((len(entries), settings, len(names), *grid.shape), np.nan)
    for entry, (_, said) in enumerate(entries):
        factors[entry, : said.shared.size] = said.log_factor.reshape(-1, len(names), *grid.shape)
    cells = ("y", "x")
    return xarray.Dataset(
        {
            "belief": (("target", *cells), np.stack([posterior.belief(t) for t in targets])),
            "log_prior": (("target", *cells), over_cells(posterior.log_prior)),
            "log_sensed": (("target", *cells), over_cells(posterior.log_sensed)),
            "log_factor": (("entry", "setting", "component", *cells), factors),
            "entry_target": ("entry", np.array([targets.index(t) for t, _ in entries], dtype=int)),
            "entry_description": (
                "entry",
                np.array([descriptions.index(said.description) for _, said in entries], dtype=int),
            ),
        },
        coords={
            "target": targets,
            "component": names,
            "y": ("y", grid.y_m, {"units": "m", "long_name": "north of the map's centre"}),
            "x": ("x", grid.x_m, {"units": "m", "long_name": "east of the map's centre"}),
        },
        attrs={
            "title": "sloop_ppl posterior",
            "format": _FORMAT,
            "map": posterior.city.name,
            "map_digest": posterior.city.digest,
            "model": posterior.model.name,
            "variant": posterior.model.variant,
            "engine": posterior.engine,
            "log_evidence": posterior.log_evidence,
            "descriptions": json.dumps([asdict(d) for d in descriptions]),
            "map_geojson": json.dumps(to_geojson(posterior.city)),
        },
    )


def save_posterior(posterior: Posterior, path: str | Path) -> None:
    """Write a posterior to a ``.nc`` file, whole or not at all.

    Raises
    ------
    InputError : when the model is made of parts that are not registered.
    OutputError : when the file cannot be written.

    Notes
    -----
    The model goes with it as :func:`sloop_ppl.models.parts.parts_of` writes it, numbers and all, so
    that a model with parameters of its own, or whose defaults change later, is read as it was.
    """
    target = check_output(path, (".nc",))
    parts = json.dumps(parts_of(posterior.model))
    with written_whole(target) as temporary:
        to_dataset(posterior).assign_attrs(model_parts=parts).to_netcdf(
            temporary, engine="h5netcdf"
        )


def load_posterior(path: str | Path) -> Posterior:
    """Read a posterior from a ``.nc`` file."""
    data = read_netcdf(path, "Posterior")
    if data.attrs.get("title") != "sloop_ppl posterior":
        raise InputError(f"File '{path}' is not a posterior saved by sloop_ppl")
    if data.attrs.get("format") != _FORMAT:
        raise InputError(
            f"Posterior '{path}' has format {data.attrs.get('format')}; expected {_FORMAT}; "
            "infer it again with this version"
        )
    try:
        return _from_dataset(data)
    except KeyError as error:
        raise InputError(f"Posterior '{path}' lacks {error}; infer it again") from error
    except (InputError, TypeError, ValueError) as error:
        raise InputError(f"Posterior '{path}' cannot be read: {error}") from error


def _from_dataset(data: xarray.Dataset) -> Posterior:
    city = from_geojson(json.loads(data.attrs["map_geojson"]))
    model = model_from_parts(json.loads(data.attrs["model_parts"]))
    descriptions = [_description(d) for d in json.loads(data.attrs["descriptions"])]
    targets = [str(t) for t in data["target"].values]
    terms = [ground_description(description, city, model) for description in descriptions]
    shared = [share_frames(list(by_target.values()), model) for by_target in terms]
    names = tuple(str(name) for name in data["component"].values)
    if names != tuple(part.name for part in model.components):
        raise InputError(
            f"it holds {len(names)} components; its model has {len(model.components)}, or others"
        )
    said: dict[str, tuple[Said, ...]] = dict.fromkeys(targets, ())
    for entry in range(data.sizes["entry"]):
        target = targets[int(data["entry_target"][entry])]
        which = int(data["entry_description"][entry])
        factor = data["log_factor"][entry, : shared[which].size].values
        said[target] += (
            Said(
                description=descriptions[which],
                components=names,
                log_factor=factor.reshape(shared[which].size, len(names), -1),
                terms=terms[which][target],
                shared=shared[which],
            ),
        )
    return Posterior(
        city=city,
        model=model,
        engine=str(data.attrs["engine"]),
        log_prior={t: data["log_prior"].sel(target=t).values.reshape(-1) for t in targets},
        said=said,
        log_sensed={t: data["log_sensed"].sel(target=t).values.reshape(-1) for t in targets},
    )


def _description(data: dict[str, Any]) -> Description:
    """Rebuild a description from what :func:`dataclasses.asdict` and JSON made of it."""
    targets = tuple(TargetObject(**{**t, "names": tuple(t["names"])}) for t in data["targets"])
    relations = tuple(
        SpatialRelation(
            **{
                **r,
                "grounds": tuple(r["grounds"]),
                "spans": r["spans"]
                and RelationSpans(
                    figure=_span(r["spans"]["figure"]),
                    relation=_span(r["spans"]["relation"]),
                    grounds=tuple(_span(s) for s in r["spans"]["grounds"]),
                ),
            }
        )
        for r in data["relations"]
    )
    unresolved = tuple(
        Unresolved(u["text"], _span(u["span"]), tuple(u["candidates"])) for u in data["unresolved"]
    )
    return Description(data["text"], data["map"], targets, relations, unresolved)


def _span(value: list[int]) -> tuple[int, int]:
    start, end = value
    return start, end

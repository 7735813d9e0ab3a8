"""Full enumeration: every latent of the open Pyro program, frames and lapses too."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np
import pyro
import torch
from numpy.typing import NDArray
from pyro import poutine
from pyro.infer import config_enumerate
from torch import Tensor

from sloop_ppl.inference.engine import ENGINES, LogFactors
from sloop_ppl.maps import CityMap
from sloop_ppl.models import OpenProgram, Preset, RelationTerm, open_program

__all__ = ["enumerate_all", "enumerated_joint"]

_FRAME_BINS = 1440


def enumerate_all(
    terms: Sequence[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    *,
    log_prior: NDArray[np.float64],
    truths: Sequence[tuple[float, float]] | None = None,
    rng: np.random.Generator | None = None,  # noqa: ARG001 - nothing is drawn
) -> LogFactors:
    """Weigh component and cell of each target, summing out frames and lapses one by one.

    The parity reference of the exact engine, for grids up to 41 x 41; frames lie on 1440 angles.
    Parameters are those of :func:`sloop_ppl.inference.exact`.
    """
    names = tuple(f"target{i}" for i in range(len(terms)))
    with torch.no_grad():
        program = open_program(
            names, list(terms), city, model, log_prior=torch.from_numpy(log_prior), truths=truths,
            frame_bins=_FRAME_BINS,
        )  # fmt: skip
    tables = []
    for name in names:
        keep = ("shared", f"{name}/component", f"{name}/cell")
        tables.append(enumerated_joint(program, name, keep).numpy())
    return LogFactors(program.evidence.components, program.evidence.shared, np.stack(tables))


def enumerated_joint(program: OpenProgram, target: str, keep: Sequence[str]) -> Tensor:
    """Return the log joint over the sites kept, all others of the target summed out.

    Parameters
    ----------
    program : an open program.
    target : id of the target whose sites are looked at.
    keep : names of its discrete sites, one axis each, in this order.

    Returns
    -------
    Tensor
        Log of prior times likelihood, with the priors of cells and shared frames left out.
    """
    alone = poutine.block(program, hide_fn=lambda site: _of_another(site["name"], target))
    with pyro.validation_enabled(False), torch.no_grad():
        enumerated = poutine.enum(config_enumerate(alone), first_available_dim=-1)
        trace = poutine.trace(enumerated).get_trace()
        trace.compute_log_prob()
    dims = {
        name: site["infer"]["_enumerate_dim"]
        for name, site in trace.nodes.items()
        if site["type"] == "sample" and site["infer"].get("_enumerate_dim") is not None
    }
    factors = [
        site["log_prob"]
        for name, site in trace.nodes.items()
        if site["type"] == "sample" and name not in ("shared", f"{target}/cell")
    ]
    for name, dim in dims.items():
        if name not in keep:
            factors = _summed_out(factors, dim)
    total: Tensor = functools.reduce(torch.add, factors)
    axes = [total.dim() + dims[name] if name in dims else None for name in keep]
    others = [axis for axis in range(total.dim()) if axis not in axes]
    kept: Tensor = total.permute(*others, *(axis for axis in axes if axis is not None)).reshape(
        [total.shape[axis] for axis in axes if axis is not None]
    )
    for position, axis in enumerate(axes):
        if axis is None:
            kept = kept.unsqueeze(position)
    return kept


def _summed_out(factors: list[Tensor], dim: int) -> list[Tensor]:
    """Replace the factors that depend on one enumerated dimension by their sum over it."""
    involved = [f for f in factors if f.dim() >= -dim and f.shape[dim] > 1]
    others = [f for f in factors if not (f.dim() >= -dim and f.shape[dim] > 1)]
    if not involved:
        return others
    return [*others, torch.logsumexp(functools.reduce(torch.add, involved), dim, keepdim=True)]


def _of_another(name: str | None, target: str) -> bool:
    return name is not None and "/" in name and not name.startswith(f"{target}/")


ENGINES.add("enumerate", enumerate_all)

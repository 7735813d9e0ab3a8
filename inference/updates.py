"""Tell a posterior more: another description, or what a sensor saw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, NoRelationFound
from sloop_ppl.inference.collapse import check_possible
from sloop_ppl.inference.infer import infer_description
from sloop_ppl.inference.posterior import Posterior
from sloop_ppl.language import Description

__all__ = ["conditioned", "updated"]


def updated(
    posterior: Posterior, description: Description, rng: np.random.Generator | None
) -> Posterior:
    """Return a posterior after one more description; see :meth:`Posterior.update`."""
    if not description.targets:
        raise NoRelationFound(
            f"'{description.text}' says nothing of any target; expected at least one relation"
        )
    later, _ = infer_description(
        description, posterior.city, posterior.model, posterior.engine, prior=None, rng=rng
    )
    new_prior = {t: p for t, p in later.log_prior.items() if t not in posterior.log_prior}
    after = replace(
        later,
        log_prior={**posterior.log_prior, **new_prior},
        said={
            target: (*posterior.said.get(target, ()), *later.said.get(target, ()))
            for target in dict.fromkeys((*posterior.targets, *later.targets))
        },
        log_sensed={**later.log_sensed, **posterior.log_sensed},
        _cache={},
    )
    return check_possible(after, description, posterior)


def conditioned(
    posterior: Posterior, log_likelihood: Mapping[str, NDArray[np.float64]]
) -> Posterior:
    """Return a posterior after sensing; see :meth:`Posterior.condition`."""
    sensed = dict(posterior.log_sensed)
    for target, table in log_likelihood.items():
        posterior._said(target)
        flat = np.asarray(table, dtype=np.float64)
        if flat.shape != posterior.city.grid.shape:
            raise InputError(
                f"Log likelihood of '{target}' has shape {flat.shape}; expected "
                f"{posterior.city.grid.shape}"
            )
        if np.isnan(flat).any() or np.isposinf(flat).any():
            raise InputError(f"Log likelihood of '{target}' holds NaN or +inf")
        sensed[target] = sensed[target] + flat.reshape(-1)
    after = replace(posterior, log_sensed=sensed, _cache={})
    return check_possible(after, log_likelihood, posterior)

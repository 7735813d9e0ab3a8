"""Hand a posterior to ArviZ (version 0.x): draws in the groups that its plots expect."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.draws import draws_from, uniforms_for

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = ["import_arviz", "to_arviz"]


def to_arviz(posterior: Posterior, n: int, rng: np.random.Generator | None) -> Any:
    """Return an ArviZ InferenceData of draws from a posterior.

    Parameters
    ----------
    posterior : what is believed.
    n : draws per target, > 0; they are one chain.
    rng : where they are drawn from; None for draws that lie evenly, the same every time.

    Returns
    -------
    arviz.InferenceData
        Group ``posterior`` with, for each target T, ``T_x``, ``T_y`` (metres), ``T_component``
        (index into the attribute ``components``, one per description) and ``T_front`` (radians,
        one per frame); group ``constant_data`` with the exact ``belief`` and ``log_prior`` over
        cells.

    Raises
    ------
    InputError : when ArviZ is not installed, or is a version without InferenceData.

    Notes
    -----
    The draws are independent, so r-hat and effective sample sizes say nothing about them; entropy
    and HPD regions are exact in the Posterior itself.
    """
    arviz = import_arviz()
    names = [part.name for part in posterior.model.components]
    drawn: dict[str, xarray.DataArray] = {}
    for target in posterior.targets:
        draws = draws_from(posterior, target, uniforms_for(posterior, target, n, rng))
        index = np.searchsorted(np.sort(names), draws["component"].values)
        draws["component"] = draws["component"].copy(data=np.argsort(names)[index])
        draws = draws.drop_vars(["row", "col", "ground", "relation"]).expand_dims(chain=[0])
        draws = draws.assign_coords(draw=np.arange(n))
        own = {"description": f"{target}_description", "frame": f"{target}_frame"}
        for name, array in draws.data_vars.items():
            if array.size:
                drawn[f"{target}_{name}"] = array.rename(
                    {k: v for k, v in own.items() if k in array.dims}
                )
    attrs = {
        "inference_library": "sloop_ppl",
        "model": posterior.model.name,
        "map": posterior.city.name,
        "components": names,
    }
    return arviz.InferenceData(
        posterior=xarray.Dataset(drawn, attrs=attrs),
        constant_data=posterior.dataset[["belief", "log_prior"]],
    )


def import_arviz() -> Any:
    """Import ArviZ without its notice about the coming version."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)
            import arviz
    except ImportError as error:
        raise InputError(
            "ArviZ is not installed; install it with: pip install 'sloop-ppl[arviz]'"
        ) from error
    if not hasattr(arviz, "InferenceData"):
        raise InputError(
            f"ArviZ {arviz.__version__} has no InferenceData; expected a version below 1: pip "
            "install 'sloop-ppl[arviz]'"
        )
    return arviz

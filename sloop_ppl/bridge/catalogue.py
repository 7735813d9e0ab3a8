"""List the names a user can choose from."""

from __future__ import annotations

from importlib import import_module

from sloop_ppl.registry import Registry

__all__ = ["names_of"]

# What can be listed -> module and name of its registry, or of the function that lists it.
_CATALOGUE: Registry[tuple[str, str]] = Registry("list")
_CATALOGUE.add("models", ("sloop_ppl.models", "PRESETS"))
_CATALOGUE.add("likelihoods", ("sloop_ppl.models", "LIKELIHOODS"))
_CATALOGUE.add("engines", ("sloop_ppl.inference", "ENGINES"))
_CATALOGUE.add("planners", ("sloop_ppl.search", "list_planners"))
_CATALOGUE.add("frames", ("sloop_ppl.models", "FRAME_PREDICTORS"))
_CATALOGUE.add("priors", ("sloop_ppl.models", "CELL_PRIORS"))
_CATALOGUE.add("candidates", ("sloop_ppl.eval.candidates", "CANDIDATES"))
_CATALOGUE.add("maps", ("sloop_ppl.maps", "bundled_maps"))


def names_of(what: str) -> list[str]:
    """Return the names of what there is to choose from, such as models or planners.

    Raises
    ------
    UnknownName : when `what` is none of these.

    Examples
    --------
    >>> names_of("maps")
    ['austin', 'cleveland', 'denver', 'honolulu', 'washington_dc']
    """
    module, name = _CATALOGUE[what]
    found = getattr(import_module(module), name)
    return list(found() if callable(found) else found)

"""List the names a user can choose from."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from importlib import import_module

from sloop_ppl.registry import Registry

__all__ = ["CATALOGUE", "Listed", "names_of"]


@dataclass(frozen=True)
class Listed:
    """Where the names of one kind of thing are found.

    Parameters
    ----------
    registry
        Module and name of its registry.
    names
        Module and name of the same names where importing costs little.
    """

    registry: tuple[str, str]
    names: tuple[str, str]


_MODELS, _MODEL_NAMES = "sloop_ppl.models", "sloop_ppl.models._model_names"

CATALOGUE: Registry[Listed] = Registry("list")
"""What can be listed."""

CATALOGUE.add("models", Listed((f"{_MODELS}.presets", "PRESETS"), (_MODEL_NAMES, "PRESET_NAMES")))
CATALOGUE.add(
    "likelihoods",
    Listed((f"{_MODELS}.likelihoods", "LIKELIHOODS"), (_MODEL_NAMES, "LIKELIHOOD_NAMES")),
)
CATALOGUE.add(
    "engines",
    Listed(
        ("sloop_ppl.inference.engines", "ENGINES"),
        ("sloop_ppl.inference._engine_names", "ENGINE_NAMES"),
    ),
)
CATALOGUE.add(
    "planners",
    Listed(
        ("sloop_ppl.planning.planners", "PLANNERS"), ("sloop_ppl.planning.planners", "PLANNERS")
    ),
)
CATALOGUE.add(
    "frames",
    Listed((f"{_MODELS}.frames", "FRAME_PREDICTORS"), (_MODEL_NAMES, "FRAME_PREDICTOR_NAMES")),
)
CATALOGUE.add(
    "priors",
    Listed((f"{_MODELS}.cell_priors", "CELL_PRIORS"), (_MODEL_NAMES, "CELL_PRIOR_NAMES")),
)
CATALOGUE.add(
    "candidates",
    Listed(
        ("sloop_ppl.eval._candidates", "CANDIDATES"),
        ("sloop_ppl.eval._candidate_names", "CANDIDATE_NAMES"),
    ),
)
CATALOGUE.add(
    "questions",
    Listed(
        ("sloop_ppl.bridge.asking.kinds", "QUESTION_KINDS"),
        ("sloop_ppl.bridge.asking.kinds", "QUESTION_KINDS"),
    ),
)
CATALOGUE.add("maps", Listed(("sloop_ppl.maps", "map_names"), ("sloop_ppl.maps", "map_names")))


def names_of(what: str) -> list[str]:
    """Return the names of what there is to choose from, such as models or planners.

    Raises
    ------
    UnknownName
        When `what` is none of these.

    Notes
    -----
    A registry that is loaded already is asked itself, for its user may have added to it.

    Examples
    --------
    >>> names_of("maps")
    ['austin', 'cleveland', 'denver', 'honolulu', 'suburb', 'washington_dc']
    """
    listed = CATALOGUE[what]
    # Names lie in modules that load neither torch nor numba; the registry itself when it is loaded.
    module, name = listed.registry if listed.registry[0] in sys.modules else listed.names
    found = getattr(import_module(module), name)
    return list(found() if callable(found) else found)

"""Turn what a person says about where something is into a belief over a city map, and search it.

Examples
--------
>>> import sloop_ppl as sloop
>>> city = sloop.load_map("cleveland")
>>> said = sloop.parse("the green toyota is behind velvet dog", city)
>>> said.relations[0].relation
'behind'
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# Names load on first use (PEP 562), so that importing the package costs neither torch nor spaCy.
_HOME = {
    "CityMap": "sloop_ppl.maps",
    "Description": "sloop_ppl.language",
    "Episode": "sloop_ppl.planning",
    "Grid": "sloop_ppl.maps",
    "Posterior": "sloop_ppl.inference",
    "SpatialRelation": "sloop_ppl.language",
    "TargetObject": "sloop_ppl.language",
    "ask": "sloop_ppl.bridge",
    "infer": "sloop_ppl.bridge",
    "infer_many": "sloop_ppl.eval",
    "load_map": "sloop_ppl.maps",
    "parse": "sloop_ppl.bridge",
    "search": "sloop_ppl.bridge",
    "widget": "sloop_ppl.web",
}
_ROOMS = ("bridge", "eval", "inference", "language", "maps", "models", "planning", "plots", "web")

__all__ = [
    "CityMap",
    "Description",
    "Episode",
    "Grid",
    "Posterior",
    "SpatialRelation",
    "TargetObject",
    "__version__",
    "ask",
    "bridge",
    "eval",
    "infer",
    "infer_many",
    "inference",
    "language",
    "load_map",
    "maps",
    "models",
    "parse",
    "planning",
    "plots",
    "search",
    "web",
    "widget",
]

if TYPE_CHECKING:
    from sloop_ppl import bridge, eval, inference, language, maps, models, planning, plots, web  # noqa: A004
    from sloop_ppl.bridge import ask, infer, parse, search
    from sloop_ppl.eval import infer_many
    from sloop_ppl.inference import Posterior
    from sloop_ppl.language import Description, SpatialRelation, TargetObject
    from sloop_ppl.maps import CityMap, Grid, load_map
    from sloop_ppl.planning import Episode
    from sloop_ppl.web import widget


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return import_module(f"sloop_ppl.{name}")
    if name not in _HOME:
        raise AttributeError(f"module 'sloop_ppl' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)

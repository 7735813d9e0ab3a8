"""Where language meets planning: the facade functions, reports, and what commands ask for.

Names load on first use, because `infer` brings torch with it, and `search` pomdp-py.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later

if TYPE_CHECKING:
    from sloop_ppl.bridge import asking
    from sloop_ppl.bridge.asking.candidates import ask
    from sloop_ppl.bridge.asking.question import Question
    from sloop_ppl.bridge.asking.questioner import Dialogue
    from sloop_ppl.bridge.explain import explain_lines
    from sloop_ppl.bridge.facade import infer, parse
    from sloop_ppl.bridge.pomdp import LanguageObservationModel, Utterance, as_histogram
    from sloop_ppl.bridge.posterior_episode import PosteriorEpisode
    from sloop_ppl.bridge.relation_text import relations_in_words
    from sloop_ppl.bridge.searching import search
    from sloop_ppl.bridge.sheets import figure_of

__all__ = [
    "Dialogue",
    "LanguageObservationModel",
    "PosteriorEpisode",
    "Question",
    "Utterance",
    "as_histogram",
    "ask",
    "asking",
    "explain_lines",
    "figure_of",
    "infer",
    "parse",
    "relations_in_words",
    "search",
]

_HOMES = {
    "asking": (),
    "asking.candidates": ("ask",),
    "asking.question": ("Question",),
    "asking.questioner": ("Dialogue",),
    "explain": ("explain_lines",),
    "facade": ("infer", "parse"),
    "pomdp": ("LanguageObservationModel", "Utterance", "as_histogram"),
    "posterior_episode": ("PosteriorEpisode",),
    "relation_text": ("relations_in_words",),
    "searching": ("search",),
    "sheets": ("figure_of",),
}
__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)

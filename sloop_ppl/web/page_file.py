"""A belief, or a search, as one HTML file that needs no server and no network."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sloop_ppl.errors import InputError
from sloop_ppl.outputs import check_output, written_whole
from sloop_ppl.web._payloads import belief_payload, frames_payload
from sloop_ppl.web._scene import scene_of
from sloop_ppl.web._search_worker import belief_tables, episode_payload, step_payload
from sloop_ppl.web._stylesheet import colour_tables, static_text, style_sheet

if TYPE_CHECKING:
    from sloop_ppl.inference import Posterior
    from sloop_ppl.planning import Episode, Step
    from sloop_ppl.planning.space import SearchSpace

__all__ = ["check_page", "search_payload", "shown_payload", "write_page"]


def check_page(path: str | Path) -> Path:
    """Return the path when a page can be written there; call it before the work.

    Raises
    ------
    OutputError
        When it does not end in ``.html`` or cannot be written.
    """
    return check_output(path, (".html",))


def write_page(
    path: str | Path,
    posterior: Posterior,
    episode: Episode | None = None,
    *,
    seed: int = 0,
) -> None:
    """Write a belief, or a search step by step, as a page of its own.

    Parameters
    ----------
    path
        The file to write, ``.html``.
    posterior
        What was believed before the search.
    episode
        The search, if there was one, with its beliefs: ``sloop.search(..., keep_beliefs=True)``.
    seed
        The seed it was run with, to be kept.

    Raises
    ------
    InputError
        When the episode has kept no beliefs.
    OutputError
        When the path cannot be written.
    """
    target = check_page(path)
    data = shown_payload(posterior, episode, seed=seed)
    parts = {
        "title": re.sub("[<&>]", "", f"{posterior.city.name} - sloop_ppl"),
        "style": style_sheet(),
        "module": static_text("view.js").replace("</", "<\\/"),
        # As text of a script element nothing but "</" and "<!--" would be read as markup.
        "data": json.dumps(data, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c"),
    }
    page = re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], static_text("page.html"))
    with written_whole(target) as part:
        part.write_text(page, encoding="utf-8")


def shown_payload(
    posterior: Posterior,
    episode: Episode | None = None,
    *,
    seed: int = 0,
) -> dict[str, Any]:
    """Return what the module `view.js` shows: map, belief, frames and perhaps a search.

    Parameters
    ----------
    posterior, episode, seed
        See `write_page`.
    """
    payload: dict[str, Any] = {
        "scene": scene_of(posterior.city, posterior.city.name),
        "colours": colour_tables(),
        "text": " ".join(posterior.texts),
        "belief": belief_payload(posterior),
        "frames": frames_payload(posterior),
        "search": None,
    }
    if episode is not None:
        payload["search"] = search_payload(posterior, episode, seed)
    return payload


def search_payload(posterior: Posterior, episode: Episode, seed: int) -> dict[str, Any]:
    """Return a search as the page plays it; see `write_page`."""
    from sloop_ppl.planning.space import SearchSpace

    if len(episode.beliefs) != episode.steps + 1:
        raise InputError(
            "The episode has not kept its beliefs, which are played; search with keep_beliefs=True"
        )
    space = SearchSpace.of_city(posterior.city, posterior.targets, episode.config)
    start = episode.poses[0]
    return {
        "places": {name: list(at) for name, at in episode.places.items()},
        "pose": [start.x_m, start.y_m, start.heading_rad],
        "beliefs": belief_tables(episode.beliefs[0]),
        "steps": [step_payload(step, space) for step in _steps_of(episode, space)],
        **episode_payload(episode, seed),
    }


def _steps_of(episode: Episode, space: SearchSpace) -> list[Step]:
    """Return the steps of an episode as a search reports them."""
    from sloop_ppl.planning import Step

    steps, found = [], set[str]()
    for i, action in enumerate(episode.actions):
        view = episode.views[i + 1]
        if action.startswith("find") and episode.rewards[i] > 0:
            # A find marks what truly is in view; where that is not known, the end tells.
            found |= {
                name
                for name in episode.found_targets
                if name in episode.places and view[space.grid.cell_at(*episode.places[name])]
            }
        if i == episode.steps - 1:
            found |= set(episode.found_targets)
        steps.append(
            Step(
                index=i,
                action=action,
                pose=episode.poses[i + 1],
                observation=episode.observations[i],
                reward=episode.rewards[i],
                found_targets=tuple(t for t in episode.found_targets if t in found),
                view=view,
                beliefs=episode.beliefs[i + 1],
                info=episode.info[i],
            )
        )
    return steps

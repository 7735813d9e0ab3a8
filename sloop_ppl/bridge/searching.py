"""Search for the targets of a posterior: the facade over planning."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from sloop_ppl.bridge._map_check import check_map
from sloop_ppl.bridge._timed_utterances import descriptions_of
from sloop_ppl.bridge._tracking import BeliefTracker
from sloop_ppl.bridge.posterior_episode import (
    OneLeg,
    PosteriorEpisode,
    SearchSetup,
    after,
    joined,
)
from sloop_ppl.errors import InputError
from sloop_ppl.inference import Posterior
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.planning import Environment, SearchConfig, SearchInterrupted, run_search
from sloop_ppl.planning.planners import planner_of
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from sloop_ppl.bridge.asking.questioner import Dialogue
    from sloop_ppl.planning import AskedQuestion, Episode, Motion, Sensor, Step

__all__ = ["Places", "imagined_places", "search", "search_legs"]

Places = Mapping[str, tuple[float, float]]


def search(
    posterior: Posterior,
    city: CityMap,
    places: Places | None = None,
    planner: str | Any = "fast",
    sims: int = 1000,
    sensor_range_cells: float = 3,
    start: tuple[float, ...] | None = None,
    *,
    rng: np.random.Generator,
    config: SearchConfig | None = None,
    sensor: Sensor | str | None = None,
    motion: Motion | None = None,
    environment: Environment | None = None,
    on_step: Callable[[Step], None] | None = None,
    notify: Callable[[str], None] | None = None,
    keep_beliefs: bool = False,
    said: Mapping[int, str | Description] | None = None,
    one_at_a_time: bool = False,
    dialogue: Dialogue | Callable[[Places], Dialogue] | None = None,
    on_question: Callable[[AskedQuestion], None] | None = None,
) -> PosteriorEpisode:
    """Search the map for the targets of a posterior, all of them jointly.

    Parameters
    ----------
    posterior
        What is believed about where the targets are. Where targets share a frame, what is seen of
        one moves the beliefs of the others.
    city
        The map the posterior was made on.
    places
        True place of each target, x and y in metres. One that is not given is drawn from the
        posterior (after all in `said`) and named in `Episode.imagined`.
    planner
        Name of a planner, see `sloop list planners`; or a planner, such as
        ``sloop_ppl.planning.Pouct(sims=500)`` or any object with a method ``plan``.
    sims
        Simulations per step, > 0.
    sensor_range_cells
        How far the sensor sees, cells, >= 1.
    start
        x and y in metres and, if given, heading in degrees; drawn when None, within the area of
        the posterior if it has one.
    rng
        Where start, imagined places, environment and planner draw from.
    config
        The other settings; `sims` and `sensor_range_cells` take the place of its own.
    sensor, motion
        What the robot senses and how moves change its pose; those of the settings when None. See
        `sloop_ppl.planning.run_search`.
    environment
        Where the search takes place, such as a simulator, which knows the true places; a simulated
        grid when None.
    on_step
        Called with every step when it is done.
    notify
        Called with each line that is to be said before the first step: what the size of the map
        sets, belief that is out of reach, that machine code is compiled.
    keep_beliefs
        Keep the beliefs after every step in the episode.
    said
        Steps taken -> what is said then, 0 before the first; a text is read in the light of what
        was said before it.
    one_at_a_time
        Search for one target after the other, as the paper does, each time from where the last
        search ended and for `SearchConfig.max_steps` steps at most.

    Returns
    -------
    PosteriorEpisode
        Poses, actions, observations, rewards and what was found, with the posterior after it all;
        ``episode.update(description)`` and ``episode.go_on(rng=...)`` take it further.

    Raises
    ------
    InputError
        When the posterior was made on another map, or a place is of no target.
    OutsideMap
        When a place or the start is outside the map.
    UnknownName
        When there is no such planner.
    NoRelationFound
        When something that is said speaks of no target.
    SearchInterrupted
        On Ctrl-C; it is a KeyboardInterrupt and holds the episode so far.

    Examples
    --------
    >>> import numpy as np
    >>> import sloop_ppl as sloop
    >>> post = sloop.infer("The red bike is west of Hoyt Block.", "cleveland")
    >>> places = {"RedBike": (-37.5, -72.5)}
    >>> run = sloop.search(post, post.city, places, planner="greedy", rng=np.random.default_rng(0))
    >>> run.found
    True
    """
    chosen = planner_of(planner)
    check_map(posterior, city)
    utterances = descriptions_of(posterior, said or {})
    informed = posterior
    for step, description in utterances.items():
        # Imagined places must agree with all that will be said, else a later sentence would be
        # untrue.
        informed = informed.update(description, rng=child(rng, "said", step))
    imagined: dict[str, tuple[float, float]] = {}
    if environment is None:
        imagined = imagined_places(informed, places or {}, rng=rng, targets=posterior.targets)
    settings = replace(
        config or SearchConfig(), sims=sims, sensor_range_cells=float(sensor_range_cells)
    )
    targets, known = posterior.targets, {**(places or {}), **imagined}
    asked = dialogue(known) if callable(dialogue) else dialogue
    try:
        episode = search_legs(
            posterior,
            known,
            tuple((t,) for t in targets) if one_at_a_time else (targets,),
            setup=SearchSetup(chosen, sensor, motion, environment, search_legs, asked),
            config=settings,
            start=start,
            rng=rng,
            on_step=on_step,
            notify=notify,
            keep_beliefs=keep_beliefs,
            utterances=utterances,
            on_question=on_question,
        )
    except SearchInterrupted as stopped:
        stopped.episode = replace(stopped.episode, imagined=tuple(imagined))
        raise
    return replace(episode, imagined=tuple(imagined))


def search_legs(
    posterior: Posterior,
    places: Places,
    legs: Sequence[tuple[str, ...]],
    *,
    setup: SearchSetup,
    config: SearchConfig,
    start: tuple[float, ...] | None,
    rng: np.random.Generator,
    on_step: Callable[[Step], None] | None = None,
    notify: Callable[[str], None] | None = None,
    keep_beliefs: bool = False,
    utterances: Mapping[int, Description] = MappingProxyType({}),
    on_question: Callable[[AskedQuestion], None] | None = None,
) -> PosteriorEpisode:
    """Search for groups of targets, one group after the other; arguments as in `search`.

    Parameters
    ----------
    legs
        The targets of each group.
    setup
        The planner, and what is not of the settings.
    """
    tracker = BeliefTracker(posterior, utterances, recovery_weight=config.recovery_weight, rng=rng)
    if 0 in utterances:
        tracker.update(utterances[0])
    for name in places:
        if name not in posterior.targets:
            raise InputError(
                f"'{name}' has no belief; expected a place for each of: "
                f"{', '.join(posterior.targets)}"
            )
    questioner, left = None, 0
    if setup.dialogue is not None:
        from sloop_ppl.bridge.asking.questioner import PosteriorQuestioner

        questioner = PosteriorQuestioner(tracker, setup.dialogue, notify=notify)
        left = setup.dialogue.most
    whole: PosteriorEpisode | None = None
    for number, leg in enumerate(legs):
        beliefs = {t: tracker.posterior.belief(t) for t in posterior.targets}
        tracker.searched = leg
        environment, others = setup.environment, set(posterior.targets).difference(leg)
        if others and isinstance(environment, Environment):
            environment = OneLeg(environment, others)

        def notify_step(step: Step, before: PosteriorEpisode | None = whole) -> None:
            if on_step is not None:
                on_step(after(step, before, beliefs))  # noqa: B023 - called within the leg

        def add(episode: Episode, before: PosteriorEpisode | None = whole) -> PosteriorEpisode:
            kept = tuple(
                MappingProxyType({**beliefs, **tables})  # noqa: B023 - called within the leg
                for tables in episode.beliefs
            )
            columns = {f.name: getattr(episode, f.name) for f in fields(episode)}
            new = PosteriorEpisode(**{**columns, "beliefs": kept})
            new = new if before is None else joined(before, new)
            return replace(
                new,
                posterior=tracker.posterior,
                setup=setup,
                utterances=MappingProxyType(
                    {k: v for k, v in utterances.items() if k not in tracker.pending_steps}
                ),
                pending_steps=tracker.pending_steps,
            )

        try:
            episode = run_search(
                {t: beliefs[t] for t in leg},
                posterior.city,
                {t: places[t] for t in leg if t in places},
                planner=setup.planner,
                sensor=setup.sensor,
                motion=setup.motion,
                environment=environment,
                config=config,
                start=start if whole is None or environment is not None else whole.poses[-1],
                rng=rng if number == 0 else child(rng, "leg", number),
                on_step=notify_step,
                notify=notify,
                on_observation=tracker.observe,
                keep_beliefs=keep_beliefs,
                start_area=None if posterior.area is None else posterior.area.cells,
                questioner=questioner,
                max_questions=left if whole is None else left - len(whole.questions),
                on_question=on_question,
            )
        except SearchInterrupted as stopped:
            stopped.episode = add(stopped.episode)
            raise
        whole = add(episode)
    if whole is None:
        raise InputError("The posterior holds no target; expected at least one")
    return whole


def imagined_places(
    posterior: Posterior,
    known: Places,
    *,
    rng: np.random.Generator,
    targets: Sequence[str] | None = None,
) -> dict[str, tuple[float, float]]:
    """Draw a place from the posterior for each target whose place is not known.

    Parameters
    ----------
    posterior
        What is believed. Where targets share a frame, they are drawn jointly.
    rng
        Where they are drawn from, each from its own child stream.
    targets
        Those to place; all of the posterior's when None.

    Returns
    -------
    dict
        Target -> x and y of a cell's centre that lies inside the map, metres.
    """
    grid = posterior.city.grid
    # Cells of the overhang have their centre off the map, where no target can be.
    inside = np.array([[grid.contains(x, y) for x in grid.x_m] for y in grid.y_m]).reshape(-1)
    drawn = {}
    for target in posterior.targets if targets is None else targets:
        if target not in known:
            weights = posterior.belief(target).reshape(-1) * inside
            cell = int(child(rng, "place", target).choice(grid.size, p=weights / weights.sum()))
            drawn[target] = grid.centre_of(*divmod(cell, grid.n_cols))
            if posterior.is_coupled:
                # Given the place of one, the next is drawn from what the shared frame leaves.
                at = np.full(grid.shape, -np.inf)
                at.flat[cell] = 0.0
                posterior = posterior.condition({target: at})
    return drawn

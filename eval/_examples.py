"""Keep a few whole searches of a sweep, to be looked at: the best, the median and the worst."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

from sloop_ppl.errors import OutputError
from sloop_ppl.eval._run_folder import RunFolder
from sloop_ppl.eval._sweep import Sweep
from sloop_ppl.eval.quality import beliefs_of
from sloop_ppl.eval.trials import Trial, run_trial
from sloop_ppl.planning import write_episode

__all__ = ["EXAMPLES", "example_trials", "has_examples", "write_examples"]

EXAMPLES = ("best", "median", "worst")
"""Names of the example trials, by discounted reward."""


def example_trials(trials: Sequence[Trial]) -> dict[str, Trial]:
    """Return name -> trial for each of `EXAMPLES`; of equal rewards the first by key.

    Parameters
    ----------
    trials
        At least one.
    """
    order = sorted(trials, key=lambda trial: (-trial.discounted_reward, trial.key))
    return dict(zip(EXAMPLES, (order[0], order[len(order) // 2], order[-1]), strict=True))


def has_examples(folder: RunFolder) -> bool:
    """Tell whether the example trials of a sweep are kept already."""
    return all((folder.examples / f"{example}.json").is_file() for example in EXAMPLES)


def write_examples(sweep: Sweep, folder: RunFolder) -> None:
    """Search again for the example trials, and keep the episodes with the belief at the start.

    They are trials of the first model of the primary comparison at its range.

    Raises
    ------
    OutputError
        When a file cannot be written.
    """
    primary = folder.manifest["primary"]
    name, range_cells = primary["models"][0], primary["range_cells"]
    trials = [
        trial
        for trial in folder.trials()
        if trial.key.model == name and trial.key.range_cells == range_cells
    ]
    descriptions = {searched.annotated.id: searched for searched in sweep.descriptions}
    try:
        folder.examples.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(f"'{folder.examples}' cannot be made: {error.strerror}") from error
    for example, trial in example_trials(trials).items():
        key = trial.key
        searched = descriptions[key.description]
        model = sweep.model(name, searched.annotated.map)
        belief = beliefs_of(searched.annotated, searched.description, searched.city, model)[
            key.target
        ]
        episode = run_trial(key, searched.annotated, searched.city, belief, sweep.searching)
        kept = replace(episode, beliefs=(MappingProxyType({key.target: belief}),))
        path = folder.examples / f"{example}.json"
        write_episode(kept, path, model=name, description=key.description, start=key.start)

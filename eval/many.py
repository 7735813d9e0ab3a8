"""Infer from very many descriptions, each by itself, in several processes and bounded memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache, partial
from itertools import islice
from pathlib import Path
from typing import Any

import cloudpickle
import numpy as np
from numpy.typing import NDArray

from sloop_ppl.bridge import infer
from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.eval._backends import BACKENDS, check_backend
from sloop_ppl.eval._driver_watch import Driver
from sloop_ppl.eval._worker_process import one_thread, pickled_model, unpickled_model
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.models import ObservationModel, preset

__all__ = ["InferredBeliefs", "infer_many"]

_TOGETHER = 32
"""Descriptions of one job: its results take 0.5 MB on 41 x 41 cells, and its start is shared."""

_JOBS_A_WORKER = 8
"""Jobs of each worker that are handed out at a time."""

_Item = tuple[int, "Description | str", "str | None"]


@dataclass(frozen=True, eq=False, repr=False)
class InferredBeliefs:
    """What one of many descriptions says.

    Parameters
    ----------
    index
        Its position among the descriptions, from 0.
    text
        What was said.
    map_name
        The map's name.
    beliefs
        Target -> probability of each cell, shape (H, W), summing to one; empty where `fault` is.
    fault
        Why nothing could be inferred, in one line; None where something was.
    """

    index: int
    text: str
    map_name: str
    beliefs: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    fault: str | None = None

    def __repr__(self) -> str:
        what = self.fault or ", ".join(self.beliefs)
        return f"InferredBeliefs({self.index}, {self.text[:40]!r}, {self.map_name!r}: {what})"


@dataclass(frozen=True)
class _Job:
    """Some descriptions, and the map they are on where it has no name to be loaded by."""

    items: tuple[_Item, ...]
    city: bytes | None
    model: bytes
    options: Mapping[str, Any]


def infer_many(
    descriptions: Iterable[Description | str | tuple[str, str]],
    city: CityMap | str | Path | None = None,
    model: str | ObservationModel = "bayes",
    *,
    prior: Any = None,
    area: Any = None,
    workers: int = 1,
    backend: str = "joblib",
    address: str | None = None,
    progress: Callable[[int], None] | None = None,
) -> Iterator[InferredBeliefs]:
    """Infer from many descriptions, each by itself; yield what each says, in their order.

    Parameters
    ----------
    descriptions
        Texts or descriptions of the map; or, where each has its own, pairs of a text and the name
        or path of its map, or descriptions whose map is a bundled one. They are taken as they are
        needed, so that they may come from a file line by line.
    city
        The map, or its name or path; None where each has its own.
    model
        A model's name, or an ObservationModel; a user's own is sent to the workers by value.
    prior, area
        The same before each; see :func:`sloop_ppl.infer`.
    workers
        How many processes, > 0; with one, this process itself.
    backend, address
        As in ``sloop eval search``: joblib, ray or dask, and the address of a cluster.
    progress
        Called with the number of descriptions that are done.

    Yields
    ------
    InferredBeliefs
        One for each description. What cannot be read, or says nothing, has a `fault` instead of
        beliefs, and the others go on.

    Raises
    ------
    InputError
        When `workers` is not a number above 0, a description has no map, or a cluster cannot be
        used.
    UnknownName
        When there is no such backend or model.

    Notes
    -----
    Memory is bounded by what is handed out at a time, some 250 descriptions a worker, however many
    there are. Results do not depend on the number of workers.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> texts = ["the red bike is near Ivy", "what a nice day", "the red bike is behind Rumor"]
    >>> for said in sloop.infer_many(texts, "cleveland"):
    ...     print(said.index, list(said.beliefs), said.fault is None)
    0 ['RedBike'] True
    1 [] False
    2 ['RedBike'] True
    """
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise InputError(f"workers is {workers!r}; expected a whole number above 0")
    if isinstance(descriptions, str | Description):
        raise InputError(
            "infer_many was given one description; expected many: a list, or use infer"
        )
    check_backend(backend, address)
    known = load_map(city) if isinstance(city, str | Path) else city
    pickled_city = None if known is None else cloudpickle.dumps(known)
    jobs = _jobs(
        descriptions, pickled_city, pickled_model(preset(model)), {"prior": prior, "area": area}
    )
    return _results(jobs, workers, backend, address, progress)


def _results(
    jobs: Iterator[_Job],
    workers: int,
    backend: str,
    address: str | None,
    progress: Callable[[int], None] | None,
) -> Iterator[InferredBeliefs]:
    work, done = partial(_work, driver=Driver.this()), 0
    while some := list(islice(jobs, _JOBS_A_WORKER * workers if workers > 1 else 1)):
        found: dict[int, InferredBeliefs] = {}
        for results in BACKENDS[backend](work, some, workers=workers, address=address):
            found |= {result.index: result for result in results}
            done += len(results)
            if progress:
                progress(done)
        yield from (found[index] for index in sorted(found))


def _jobs(
    descriptions: Iterable[Description | str | tuple[str, str]],
    city: bytes | None,
    model: bytes,
    options: Mapping[str, Any],
) -> Iterator[_Job]:
    numbered = (_item(i, utterance, city is not None) for i, utterance in enumerate(descriptions))
    while items := tuple(islice(numbered, _TOGETHER)):
        yield _Job(items, city, model, options)


def _item(index: int, utterance: Any, has_map: bool) -> _Item:
    """Return a description with the map it names, None where one is given for all."""
    if isinstance(utterance, str | Description) and has_map:
        return index, utterance, None
    if isinstance(utterance, Description) and utterance.map:
        return index, utterance, utterance.map
    if isinstance(utterance, tuple) and len(utterance) == 2 and not has_map:
        text, where = utterance
        if isinstance(text, str | Description) and isinstance(where, str | Path):
            return index, text, str(where)
    wanted = "a text or a Description" if has_map else "a pair of a text and a map, as no map is"
    raise InputError(
        f"Description {index} is {utterance!r:.80}; expected {wanted} "
        f"{'of the map' if has_map else 'given for all'}"
    )


def _work(job: _Job, *, driver: Driver) -> list[InferredBeliefs]:
    """Infer from the descriptions of a job in a worker."""
    with one_thread(stoppable=driver.is_this):
        return [_inferred(job, item) for item in job.items]


def _inferred(job: _Job, item: _Item) -> InferredBeliefs:
    index, utterance, where = item
    text = utterance if isinstance(utterance, str) else utterance.text
    name = where or ""
    try:
        city = _loaded(where) if where is not None else _unpickled(job.city or b"")
        name = city.name
        posterior = infer(utterance, city, unpickled_model(job.model), **job.options)
    except SloopError as error:
        return InferredBeliefs(index, text, name, fault=" ".join(str(error).split()))
    return InferredBeliefs(index, text, name, {t: posterior.belief(t) for t in posterior.targets})


@lru_cache(maxsize=16)
def _loaded(where: str) -> CityMap:
    return load_map(where)


@lru_cache(maxsize=2)
def _unpickled(city: bytes) -> CityMap:
    """Return a map that was pickled; the same object, with what was computed, for the same one."""
    import pickle

    found: CityMap = pickle.loads(city)
    return found

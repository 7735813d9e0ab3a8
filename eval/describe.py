"""Say what is in a set of descriptions: how well it is read, which relations, how many targets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._facts import facts_of, plain_word
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval._tables import Table
from sloop_ppl.eval.descriptions import AnnotatedDescription, read_descriptions
from sloop_ppl.language import RELATIONS, parse
from sloop_ppl.maps import CityMap, load_map

__all__ = ["SetSummary", "describe_files", "describe_set", "summary_tables"]


@dataclass(frozen=True)
class SetSummary:
    """What is in a set of descriptions.

    Parameters
    ----------
    descriptions, targets, configurations, speakers
        How many; speakers as far as they are told.
    words_mean
        Mean number of words of a text.
    targets_with_relation
        Targets of which the gold says something.
    targets_read
        Targets of which the parser read something.
    descriptions_read
        Descriptions of which the parser read all targets.
    good_frames, bad_frames
        Targets with frame relations whose predicted fronts are right, or not; see
        :class:`sloop_ppl.eval._facts.TargetFacts`.
    relations
        Relation -> how often the gold says it.
    relations_per_target
        Number of relations -> number of targets.
    descriptions_per_configuration, targets_per_configuration
        Number of descriptions, and of different targets -> number of configurations.
    maps
        Map -> number of descriptions.
    """

    descriptions: int
    targets: int
    configurations: int
    speakers: int
    words_mean: float
    targets_with_relation: int
    targets_read: int
    descriptions_read: int
    good_frames: int
    bad_frames: int
    relations: Mapping[str, int]
    relations_per_target: Mapping[str, int]
    descriptions_per_configuration: Mapping[str, int]
    targets_per_configuration: Mapping[str, int]
    maps: Mapping[str, int]

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop eval describe --json`` prints."""
        return asdict(self)


def describe_files(files: Sequence[str | Path], *, maps: str | Path | None = None) -> SetSummary:
    """Return what is in some files.

    Parameters
    ----------
    files
        Description files.
    maps
        Folder of map files; None for the bundled maps.

    Raises
    ------
    InputError
        When a file or one of its lines cannot be used.
    """
    find = map_finder(maps)
    return describe_set(read_descriptions(files, find), find)


def describe_set(
    descriptions: Sequence[AnnotatedDescription], find_map: Callable[[str], CityMap] = load_map
) -> SetSummary:
    """Return what is in a set of descriptions.

    Parameters
    ----------
    descriptions
        At least one.
    find_map
        Gives the map of a description by name.

    Raises
    ------
    InputError
        When there is no description.
    """
    if not descriptions:
        raise InputError("There is no description to describe; expected at least one")
    facts = [
        fact for annotated in descriptions for fact in facts_of(annotated, find_map(annotated.map))
    ]
    read, whole = 0, 0
    for annotated in descriptions:
        utterance = parse(
            annotated.text,
            find_map(annotated.map),
            annotated.objects or None,
            viewpoint=annotated.viewpoint,
            hearer=annotated.hearer,
        )
        found = {relation.figure for relation in utterance.relations}
        read += sum(target in found for target in annotated.targets)
        whole += set(annotated.targets) <= found if annotated.targets else bool(found)
    counts = Counter(
        plain_word(r.relation) for annotated in descriptions for r in annotated.relations
    )
    sizes = Counter((annotated.map, annotated.configuration) for annotated in descriptions)
    objects: dict[tuple[str, str], set[str]] = {}
    for annotated in descriptions:
        objects.setdefault((annotated.map, annotated.configuration), set()).update(
            annotated.targets
        )
    return SetSummary(
        descriptions=len(descriptions),
        targets=len(facts),
        configurations=len(sizes),
        speakers=len({annotated.speaker for annotated in descriptions} - {None}),
        words_mean=float(np.mean([len(annotated.text.split()) for annotated in descriptions])),
        targets_with_relation=sum(bool(one.relations) for one in facts),
        targets_read=read,
        descriptions_read=whole,
        good_frames=sum(one.good is True for one in facts),
        bad_frames=sum(one.good is False for one in facts),
        relations={word: counts[word] for word in sorted(counts, key=lambda w: (-counts[w], w))},
        relations_per_target=_histogram(len(one.relations) for one in facts),
        descriptions_per_configuration=_histogram(sizes.values()),
        targets_per_configuration=_histogram(map(len, objects.values())),
        maps=dict(Counter(annotated.map for annotated in descriptions)),
    )


def summary_tables(summary: SetSummary) -> list[Table]:
    """Return the summary as tables."""
    most = max(summary.relations.values(), default=1)
    counts = Table(
        "set",
        "What is in the set",
        ("", "n"),
        (
            *((f"descriptions of {name}", n) for name, n in summary.maps.items()),
            ("descriptions", summary.descriptions),
            ("configurations of objects", summary.configurations),
            ("targets", summary.targets),
            ("targets with a gold relation", summary.targets_with_relation),
            ("targets of which the parser read something", summary.targets_read),
            ("descriptions of which it read every target", summary.descriptions_read),
            ("targets with frame relations, all on the predicted side", summary.good_frames),
            ("targets with frame relations, some on the other side", summary.bad_frames),
            ("mean number of words", f"{summary.words_mean:.1f}"),
        ),
    )
    relations = Table(
        "set-relations",
        "Relations",
        ("relation", "class", "n", ""),
        tuple(
            (word, RELATIONS[word].relation_class, n, "█" * max(1, round(30 * n / most)))
            for word, n in summary.relations.items()
        ),
    )
    return [
        counts,
        relations,
        Table(
            "set-per-target",
            "Relations said of a target",
            ("relations", "targets"),
            tuple(summary.relations_per_target.items()),
        ),
        Table(
            "set-per-configuration",
            "Descriptions of one configuration",
            ("descriptions", "configurations"),
            tuple(summary.descriptions_per_configuration.items()),
        ),
        Table(
            "set-targets",
            "Targets of one configuration",
            ("targets", "configurations"),
            tuple(summary.targets_per_configuration.items()),
        ),
    ]


def _histogram(sizes: Any) -> dict[str, int]:
    found = Counter(sizes)
    return {str(size): found[size] for size in sorted(found)}

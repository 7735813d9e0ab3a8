"""Files in which people say which way grounds face: how far they agree, and labels to learn from.

Shape legend: U units, the phrases that two or more annotators judged.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl._records import Text
from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.eval._line_format import Fault, FrameLine, checked
from sloop_ppl.inference._frame_examples import FrameLabel
from sloop_ppl.maps import CityMap, load_map

__all__ = [
    "AgreementRow",
    "FrameAgreement",
    "FrameJudgement",
    "angular_alpha",
    "angular_distance",
    "circular_mean",
    "consensus",
    "frame_agreement",
    "labels_of",
    "read_judgements",
]

_LEARNT = frozenset(("front", "behind"))
"""Words whose frame is the ground's own: left and right may be the map's."""


class _UnclearLine(msgspec.Struct, frozen=True):
    ground: Text
    relation: Text
    annotator: Text | None = None


class _AnnotatedLine(msgspec.Struct, frozen=True):
    id: Text
    map: Text
    text: str = ""
    frames: list[FrameLine] = []
    unclear: _UnclearLine | None = None


@dataclass(frozen=True)
class FrameJudgement:
    """What one annotator says of one phrase.

    Parameters
    ----------
    map, text, ground, relation
        The phrase.
    annotator
        Who says so; the file's own where it names none.
    front_rad
        Where the front of the ground faces, radians anticlockwise from east; None when unclear.
    """

    map: str
    text: str
    ground: str
    relation: str
    annotator: str
    front_rad: float | None

    @property
    def unit(self) -> tuple[str, str, str, str]:
        """What other annotators may have judged as well."""
        return self.map, self.text, self.ground, self.relation


@dataclass(frozen=True)
class AgreementRow:
    """How far annotators agree on some of the phrases.

    Parameters
    ----------
    word, city
        Relation and map; None for all.
    units
        Number of phrases that two or more annotators gave a direction.
    mean_deg, median_deg
        Of the angular distances between two annotators of a phrase, each phrase counted once.
    alpha
        Krippendorff's alpha with squared angular distances; None where all say the same.
    unclear
        Share of the judgements that call the frame unclear.
    """

    word: str | None
    city: str | None
    units: int
    mean_deg: float | None
    median_deg: float | None
    alpha: float | None
    unclear: float


@dataclass(frozen=True)
class FrameAgreement:
    """How far annotators agree, in all and for each word and city.

    Parameters
    ----------
    annotators
        Their names.
    rows
        All, then by word, by city, and by both.
    """

    annotators: tuple[str, ...]
    rows: tuple[AgreementRow, ...]

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop frames agreement --json`` prints."""
        return {
            "annotators": list(self.annotators),
            "rows": [{**vars(row)} for row in self.rows],
        }


def read_judgements(paths: Sequence[str | Path]) -> list[FrameJudgement]:
    """Return what annotators say, the last word of each on a phrase.

    Parameters
    ----------
    paths
        Files that the annotation page saved, or description files with `frames`.

    Raises
    ------
    InputError
        When a file cannot be read, for the first line that does not follow the format, or when no
        line holds a frame.
    """
    latest: dict[tuple[object, ...], FrameJudgement] = {}
    for path in paths:
        for number, text in enumerate(read_text(path, "Annotations").split("\n"), start=1):
            if not text.strip():
                continue
            try:
                line = checked(parse_json(text, finite=False), _AnnotatedLine)
                found = [_judgement(line, frame, path) for frame in line.frames]
                if line.unclear is not None:
                    found.append(_judgement(line, line.unclear, path))
            except Fault as fault:
                raise InputError(f"{path}:{number}: field '{fault.field}' {fault.what}") from fault
            except ForeignFault as error:
                raise InputError(f"{path}:{number}: is not JSON: {error}") from error
            latest |= {(*one.unit, one.annotator): one for one in found}
    if not latest:
        names = ", ".join(str(path) for path in paths)
        raise InputError(f"No line of {names} has a frame; expected annotations of frames")
    return list(latest.values())


def _judgement(
    line: _AnnotatedLine, frame: FrameLine | _UnclearLine, path: str | Path
) -> FrameJudgement:
    front = math.radians(frame.front_deg) if isinstance(frame, FrameLine) else None
    annotator = frame.annotator or Path(path).stem
    return FrameJudgement(line.map, line.text, frame.ground, frame.relation, annotator, front)


def angular_distance(a: float, b: float) -> float:
    """Return the angle between two directions, radians, 0 to pi."""
    return abs(math.remainder(a - b, 2 * math.pi))


def circular_mean(angles_rad: Sequence[float]) -> float | None:
    """Return the mean direction; None where the directions cancel."""
    total = np.exp(1j * np.asarray(angles_rad)).sum()
    return None if abs(total) < 1e-9 else float(np.angle(total))


def angular_alpha(units: Sequence[Sequence[float]]) -> float | None:
    """Return Krippendorff's alpha of directions.

    Parameters
    ----------
    units
        The directions given to each phrase, radians; of one annotator or none are left out.

    Returns
    -------
    float or None
        1 for perfect agreement, 0 for that of chance; None when all directions are the same.

    Notes
    -----
    Source: Krippendorff, Content Analysis, ch. 12: 1 - D_o / D_e, pairs of a unit of m values
    weighted by 1 / (m - 1); the difference is the squared angular distance, as the squared
    difference is for interval data.
    """
    paired = [list(values) for values in units if len(values) > 1]
    if not paired:
        return None
    count = sum(len(values) for values in paired)
    observed = sum(_squares(values) / (len(values) - 1) for values in paired) / count
    expected = _squares(list(itertools.chain(*paired))) / (count * (count - 1))
    return None if expected < 1e-18 else 1 - observed / expected


def _squares(angles: Sequence[float]) -> float:
    """Return the sum of squared angular distances over ordered pairs."""
    table: NDArray[np.float64] = np.subtract.outer(np.asarray(angles), np.asarray(angles))
    turned = np.mod(table + np.pi, 2 * np.pi) - np.pi
    return float((turned**2).sum())


def frame_agreement(judgements: Sequence[FrameJudgement]) -> FrameAgreement:
    """Return how far annotators agree, in all and for each word and city.

    Raises
    ------
    InputError
        When no phrase was given a direction by two of them.

    Notes
    -----
    Source: SLOOP sec. V, which reports the disagreement of its annotators per word and city.
    """
    annotators = tuple(sorted({one.annotator for one in judgements}))
    words = sorted({one.relation for one in judgements})
    cities = sorted({one.map for one in judgements})
    groups = [(None, None), *((w, None) for w in words), *((None, c) for c in cities)]
    groups += [(w, c) for w in words for c in cities]
    rows = []
    for word, city in groups:
        some = [j for j in judgements if word in (None, j.relation) and city in (None, j.map)]
        if some:
            rows.append(_row(word, city, some))
    if not rows or not rows[0].units:
        raise InputError(
            f"No phrase was given a direction by two annotators ({', '.join(annotators)}); "
            "expected at least one"
        )
    return FrameAgreement(annotators, tuple(rows))


def _row(word: str | None, city: str | None, some: Sequence[FrameJudgement]) -> AgreementRow:
    units = [values for values in _directions(some).values() if len(values) > 1]
    off = [
        math.degrees(np.mean([angular_distance(a, b) for a, b in itertools.combinations(u, 2)]))
        for u in units
    ]
    return AgreementRow(
        word=word,
        city=city,
        units=len(units),
        mean_deg=float(np.mean(off)) if off else None,
        median_deg=float(np.median(off)) if off else None,
        alpha=angular_alpha(units),
        unclear=sum(one.front_rad is None for one in some) / len(some),
    )


def _directions(
    judgements: Sequence[FrameJudgement],
) -> dict[tuple[str, str, str, str], list[float]]:
    found: dict[tuple[str, str, str, str], list[float]] = {}
    for one in judgements:
        if one.front_rad is not None:
            found.setdefault(one.unit, []).append(one.front_rad)
    return found


def consensus(judgements: Sequence[FrameJudgement]) -> dict[tuple[str, str, str, str], float]:
    """Return the mean direction of each phrase that was given one and whose directions agree."""
    means = {unit: circular_mean(values) for unit, values in _directions(judgements).items()}
    return {unit: mean for unit, mean in means.items() if mean is not None}


def labels_of(
    judgements: Sequence[FrameJudgement],
) -> tuple[dict[str, CityMap], dict[str, list[FrameLabel]]]:
    """Return maps and, for each, which way its places face according to annotators.

    Parameters
    ----------
    judgements
        What they say; of front and behind, whose frame is the place's own.

    Returns
    -------
    tuple of dict and dict
        By the maps' names, the maps and a label for each place: the mean of all directions.

    Raises
    ------
    InputError
        When a map cannot be loaded, or a place is not on it.
    """
    maps: dict[str, CityMap] = {}
    angles: dict[str, dict[str, list[float]]] = {}
    for one in judgements:
        if one.front_rad is None or one.relation not in _LEARNT:
            continue
        if one.map not in maps:
            try:
                maps[one.map] = load_map(one.map)
            except SloopError as error:
                raise InputError(f"Annotations of map '{one.map}': {error}") from error
        maps[one.map].landmark(one.ground)
        angles.setdefault(one.map, {}).setdefault(one.ground, []).append(one.front_rad)
    labels: Mapping[str, list[FrameLabel]] = {
        name: [
            FrameLabel(ground, mean)
            for ground, values in grounds.items()
            if (mean := circular_mean(values)) is not None
        ]
        for name, grounds in angles.items()
    }
    return maps, dict(labels)

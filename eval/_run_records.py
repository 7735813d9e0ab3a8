"""The records that a sweep's folder holds, as they are checked when they are read."""

from __future__ import annotations

from typing import Annotated, Any

from msgspec import Meta, Struct

from sloop_ppl._records import Text
from sloop_ppl.eval._line_format import Flag, Number

__all__ = ["ManifestRecord", "TargetRecord", "TrialRecord"]

Count = Annotated[int, Meta(ge=0, description="a whole number of at least 0")]
Positive = Annotated[float, Meta(gt=0, le=1e300, description="a positive number")]
Seconds = Annotated[float, Meta(ge=0, le=1e300, description="a number of at least 0")]
Named = Annotated[dict[str, Text], Meta(description="an object of texts")]
Settings = Annotated[dict[str, Any], Meta(description="an object")]


class TrialRecord(Struct, frozen=True):
    """One trial, a line of a part."""

    description: Text
    target: Text
    model: Text
    range_cells: Positive
    start: Count
    map: Text
    configuration: Text
    found: Flag
    steps: Count
    discounted_reward: Number
    reward: Number
    start_x_m: Number
    start_y_m: Number
    seconds: Seconds
    questions: Count = 0
    question_cost: Seconds = 0.0
    asked: Count = 0
    gross_reward: Number | None = None
    expected_bits: Number = 0.0
    realised_bits: Number = 0.0
    log_score: Number | None = None


class _RelationRecord(Struct, frozen=True):
    """What was said of a target by one relation."""

    relation: Text
    relation_class: Text
    grounds: Annotated[tuple[Text, ...], Meta(description="a list of texts")]
    negated: Flag
    good: Flag | None


class TargetRecord(Struct, frozen=True):
    """A described target."""

    description: Text
    target: Text
    map: Text
    configuration: Text
    relations: Annotated[list[_RelationRecord], Meta(description="a list")]


class _ComparisonRecord(Struct, frozen=True):
    """The comparison that is named before the run."""

    models: Annotated[tuple[Text, Text], Meta(description="two names of models")]
    range_cells: Positive


class ManifestRecord(Struct, frozen=True):
    """What of a manifest a report needs."""

    relations: Text
    model_names: Annotated[list[Text], Meta(min_length=1, description="a list of names")]
    ranges_cells: Annotated[list[Positive], Meta(min_length=1, description="a list of numbers")]
    starts: Count
    searching: Settings
    primary: _ComparisonRecord
    n_descriptions: Count
    n_targets: Count
    n_trials: Count
    version: Text
    packages: Named
    descriptions: Named
    maps: Named
    cv: Text | None = None
    git: Text | None = None

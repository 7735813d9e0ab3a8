"""Put descriptions, beliefs and maps into words, tables and plain JSON values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rich.table import Table

from sloop_ppl.bridge.relation_text import (
    distance_in_words,
    ground_label,
    meant_lines,
    names_of,
    percent,
    reading_lines,
)
from sloop_ppl.language import HEARER, NOT_ON_MAP, Description, SpatialRelation
from sloop_ppl.language._part_words import part_in_words
from sloop_ppl.maps._whereabouts import nearest_landmark, whereabouts

if TYPE_CHECKING:
    from sloop_ppl.bridge.asking import Question
    from sloop_ppl.inference import FrameSummary, Posterior
    from sloop_ppl.language._place_names import PlaceNames
    from sloop_ppl.planning import AskedQuestion, Episode, Step

__all__ = [
    "asked_line",
    "belief_lines",
    "belief_report",
    "outcome_line",
    "question_lines",
    "relation_table",
    "step_line",
    "unlocated_line",
    "unresolved_lines",
    "why_lines",
]


_LEAST_SHARE = 0.005  # a share that would be shown as 0.00 is not


def relation_table(description: Description) -> Table:
    """Return the relations of a description with the words each was read from."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("figure", "relation", "ground", "sure", "read from"):
        table.add_column(name, overflow="fold")
    for relation in description.relations:
        word = f"not {relation.relation}" if relation.negated else relation.relation
        if distance := distance_in_words(relation):
            word += f" ({distance})"
        if relation.either is not None and relation.either[1] > 0:
            word = f"or {word}"
        table.add_row(
            relation.figure,
            word,
            part_in_words(
                relation.part,
                " and ".join(_referents(relation, i) for i in range(len(relation.grounds))),
            ),
            f"{relation.confidence:.2f}",
            _words(description, relation),
        )
    for missed in description.unresolved:
        status = "?" if missed.status == "unknown" else missed.status
        near = missed.candidates if missed.status == "unknown" else ()
        table.add_row(f"[dim]{status}[/]", "", "", "", _missed(missed.text, near))
    return table


def _referents(relation: SpatialRelation, index: int) -> str:
    """Return what one ground may be: the place, or the likeliest places with their shares."""
    slot = relation.slot(index)
    if relation.each or len(slot) == 1:
        return _referent(relation.grounds[index])
    slot = tuple(c for c in slot if c.probability >= _LEAST_SHARE)
    shares = [f"{_referent(c.ground or NOT_ON_MAP)} {c.probability:.2f}" for c in slot[:3]]
    others = slot[3:]
    if others:
        shares.append(f"{len(others)} others {sum(c.probability for c in others):.2f}")
    return ", ".join(shares)


def _referent(ground: str) -> str:
    return {NOT_ON_MAP: "not on this map", HEARER: "the hearer"}.get(ground, ground)


def unresolved_lines(posterior: Posterior) -> list[str]:
    """Return a line for each name or cue that found no home, and each part that no map has."""
    names = names_of(posterior)
    idle = [
        f"not on this map: {part_in_words(term.part, ground_label(names, term.ground))}; read as "
        f"all of {ground_label(names, term.ground)}"
        for target in posterior.targets
        for term in posterior.grounded(target)
        if term.joint and term.part and not term.has_part and not term.is_silent
    ]
    return idle + [
        (
            f"not understood: {_missed(missed.text, tuple(map(names.of, missed.candidates)))}"
            if missed.status == "unknown"
            else f"set aside ({missed.status}): “{missed.text}”"
        )
        for description in posterior.descriptions
        for missed in description.unresolved
    ]


def belief_lines(posterior: Posterior) -> list[str]:
    """Return a few lines in words: where each belief lies, how wide, and on what frame."""
    lines = []
    names = names_of(posterior)
    for target in posterior.targets:
        place = whereabouts(posterior.city, *posterior.mode(target), names.of)
        lines.append(f"{target}: most probably {place}")
        cells = int(posterior.hpd(target, 0.9).sum())
        area = cells * posterior.city.grid.cell_m**2
        lines.append(f"  90 % within {cells} cells ({area:,.0f} m2), entropy "
                     f"{posterior.entropy(target):.2f} nats")  # fmt: skip
        if not posterior.relations(target):
            lines.append(f"  {unlocated_line(posterior, target)}")
        parts = posterior.component(target)
        if len(parts) > 1:
            components_text = ", ".join(f"{name} {p:.2f}" for name, p in parts.items())
            lines.append(f"  read as: {components_text}")
        lines += [f"  {line}" for line in meant_lines(posterior, target)]
        lines += [_frame_line(frame, names) for frame in posterior.frames(target)]
    return [*lines, *reading_lines(posterior)]


def unlocated_line(posterior: Posterior, target: str) -> str:
    """Return a line about the belief of a target that nothing was said of by itself."""
    if target in posterior.related:
        return "nothing was said of it but that another lies by it"
    return "nothing was said of it: this is its prior"


def belief_report(posterior: Posterior) -> dict[str, Any]:
    """Return the value that ``sloop infer --json`` prints."""
    return {
        "map": posterior.city.name,
        "model": posterior.model.name,
        "engine": posterior.engine,
        "log_evidence": posterior.log_evidence,
        "readings": [
            {"p": one.prior, "posterior": one.p, "relations": len(one.reading.relations)}
            for one in posterior.readings()
        ],
        "targets": {target: _target_report(posterior, target) for target in posterior.targets},
    }


def step_line(step: Step) -> str:
    """Return one line on a step: what was done, what was seen, what it earned."""
    seen, reports = [], []
    for name, at in step.observation.items():
        if isinstance(at, tuple) and len(at) == 2:
            seen.append(f"{name} at ({at[0]:g}, {at[1]:g})")
        elif at is not None:
            reports.append(f"{name} {at}")
    outcome = f"saw {', '.join(seen) or 'nothing'}"
    if reports:
        outcome = f"sensor: {', '.join(reports)}"
    if step.collision:
        outcome = f"collided; {outcome}"
    if step.action.startswith("find"):
        outcome = "right" if step.reward > 0 else "wrong"
    found = f", found so far: {', '.join(step.found_targets)}" if step.found_targets else ""
    return (
        f"{step.index + 1:3d}  {step.action:<8} at ({step.pose.x_m:6.1f}, {step.pose.y_m:6.1f}) "
        f"facing {step.pose.heading_deg:3.0f}°  "
        f"{step.reward:+6.0f}  {outcome}{found}"
    )


def question_lines(questions: Sequence[Question]) -> list[str]:
    """Return each question with its answers and what it would settle, in a few lines."""
    lines = []
    for number, question in enumerate(questions, start=1):
        shares = ", ".join(f"{answer.text} {answer.p:.2f}" for answer in question.answers)
        settled = ", ".join(f"{name} {bits:.2f}" for name, bits in question.settles.items())
        lines += [
            f"{number}. {question.text}",
            f"   {question.bits:.2f} bits expected about the cell; {shares}",
            f"   settles, in bits: {settled}",
        ]
    return lines


def asked_line(question: AskedQuestion) -> str:
    """Return one line on why a question was asked."""
    worth = f", {question.gain:+.0f} reward after its cost" if question.gain is not None else ""
    return f"     it was worth asking: {question.bits:.2f} bits expected{worth}"


def outcome_line(episode: Episode) -> str:
    """Return one line on how a search ended."""
    missed = [name for name in episode.places if name not in episode.found_targets]
    found = ", ".join(episode.found_targets) or "nothing"
    summary = f"found {found} in {episode.steps} steps, discounted reward "
    summary += f"{episode.discounted_return:.1f}"
    if missed:
        summary += f"; not found: {', '.join(missed)}"
    if episode.questions:
        answers = [q.answer or "no answer" for q in episode.questions]
        cost = sum(q.cost for q in episode.questions)
        summary += f"; asked {len(answers)} (cost {cost:g}): {'; '.join(answers)}"
    if episode.imagined:
        summary += f"; imagined places: {', '.join(episode.imagined)}"
    return summary


def _target_report(posterior: Posterior, target: str) -> dict[str, Any]:
    x, y = posterior.mode(target)
    lonlat = None
    if posterior.city.grid.centre is not None:
        lonlat = [round(float(v), 7) for v in posterior.city.grid.to_lonlat(x, y)]
    nearest = nearest_landmark(posterior.city, x, y)
    return {
        "mode_m": [x, y],
        "mode_lonlat": lonlat,
        "entropy_nats": posterior.entropy(target),
        "expected_m": list(posterior.expected(target)),
        "hpd90_cells": int(posterior.hpd(target, 0.9).sum()),
        "nearest": nearest.id if nearest else None,
        "components": posterior.component(target),
        "frames": [
            {
                "ground": frame.ground,
                "relation": frame.relation,
                "mean_deg": _degrees(frame.mean_rad),
                "kappa": frame.kappa,
                "p": frame.p,
            }
            for frame in posterior.frames(target)
        ],
        "grounds": [
            {
                "relation": one.relation.relation,
                "candidates": [{"ground": c.ground, "p": c.p} for c in one.candidates],
            }
            for one in posterior.grounds(target)
        ],
    }


def _frame_line(frame: FrameSummary, names: PlaceNames) -> str:
    spread = "exactly" if frame.kappa is None else f"kappa {frame.kappa:.1f}"
    label = ground_label(names, frame.ground)
    return (
        f"  '{frame.relation}' takes {label} to face {_degrees(frame.mean_rad):.0f}° "
        f"from east ({spread}), p {frame.p:.2f}"
    )


def _degrees(angle_rad: float) -> float:
    return math.degrees(math.remainder(angle_rad, 2 * math.pi))


def _words(description: Description, relation: SpatialRelation) -> str:
    if relation.spans is None:
        return ""
    spans = relation.spans
    parts = dict.fromkeys((spans.figure, spans.relation, *spans.grounds))
    return " … ".join(f"“{description.text[a:b]}”" for a, b in parts)


def _missed(text: str, candidates: tuple[str, ...]) -> str:
    near = f"; nearest: {', '.join(candidates)}" if candidates else ""
    return f"“{text}”{near}"


def why_lines(step: Step) -> list[str]:
    """Return a line for each action that the planner could take, the chosen one marked."""
    info = step.info
    names = dict.fromkeys((*info.values, *info.expected))
    lines = []
    for name in names:
        columns = [f"     {'>' if name == step.action else ' '} {name:<8}"]
        if name in info.values:
            columns.append(f"value {info.values[name]:8.1f}")
        if name in info.visits:
            columns.append(f"visits {info.visits[name]:6d}")
        seen = info.expected.get(name)
        if seen:
            shown = ", ".join(f"{target} {percent(p, 1)}" for target, p in seen.items())
            columns.append(f"expects to see {shown}")
        lines.append("  ".join(columns))
    lines += [f"       {name}: {_note_text(value)}" for name, value in info.notes.items()]
    return lines


def _note_text(value: object) -> str:
    """Return a note in few words: moves by name, probabilities in per cent."""
    if not isinstance(value, tuple):
        return str(value)
    return " ".join(percent(v, 1) if isinstance(v, float) else str(v) for v in value)

"""Show a text with the roles of its words coloured: for a terminal, and as a page."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

from sloop_ppl.language._part_words import part_in_words
from sloop_ppl.language.values import Description

if TYPE_CHECKING:
    from rich.text import Text

__all__ = ["ROLE_COLOURS", "Role", "coloured_text", "html_page", "roles"]

ROLE_COLOURS = {
    "figure": "#009e73",
    "relation": "#e69f00",
    "ground": "#56b4e9",
    "unresolved": "#cc79a7",
}
"""Role -> colour, from a palette that colour-blind readers tell apart."""

_ORDER = ("figure", "ground", "relation", "unresolved")


@dataclass(frozen=True)
class Role:
    """What a stretch of text does.

    Parameters
    ----------
    start, end
        Half-open character range.
    role
        ``figure``, ``relation``, ``ground`` or ``unresolved``.
    label
        The id or the relation it stands for.
    """

    start: int
    end: int
    role: str
    label: str


def roles(description: Description) -> tuple[Role, ...]:
    """Return the roles of a text in order, not overlapping.

    Where one stretch has several roles the figure goes before the ground, the ground before the
    relation, and the shorter stretch before the longer.
    """
    labels: dict[tuple[int, int, str], dict[str, None]] = {}
    for relation in description.relations:
        spans = relation.spans
        if spans is None:
            continue
        entries = [(spans.figure, "figure", relation.figure)]
        word = f"not {relation.relation}" if relation.negated else relation.relation
        entries.append((spans.relation, "relation", word))
        entries += [
            (span, "ground", ground)
            for span, ground in zip(spans.grounds, relation.grounds, strict=True)
        ]
        for span, role, label in entries:
            labels.setdefault((*span, role), {})[label] = None
    for loose in description.unresolved:
        labels.setdefault((*loose.span, "unresolved"), {})["?"] = None
    taken: list[Role] = []
    wanted = sorted(labels, key=lambda k: (_ORDER.index(k[2]), k[1] - k[0], k[0]))
    owned = bytearray(len(description.text))
    for start, end, role in wanted:
        if end > start and not any(owned[start:end]):
            owned[start:end] = b"\1" * (end - start)
            taken.append(Role(start, end, role, ", ".join(labels[start, end, role])))
    return tuple(sorted(taken, key=lambda r: r.start))


def coloured_text(description: Description) -> Text:
    """Return the text for a terminal, the words of each role in its colour."""
    from rich.text import Text

    text = Text(description.text)
    for part in roles(description):
        text.stylize(f"bold {ROLE_COLOURS[part.role]}", part.start, part.end)
    return text


def html_page(description: Description) -> str:
    """Return a page with the coloured text, drawn by displaCy, and the relations under it.

    Raises
    ------
    InputError
        When spaCy is not installed.
    """
    from sloop_ppl._extras import need_extra

    need_extra("A page of a sentence", "spacy", "spacy")
    from spacy import displacy

    clean = description.text.encode("utf-8", "replace").decode("utf-8")
    marked = {
        "text": clean,
        "ents": [
            {"start": p.start, "end": p.end, "label": f"{p.role}: {escape(p.label)}"}
            for p in roles(description)
        ],
        "title": escape(f"Read on {description.map}"),
    }
    colours = {f"{p.role}: {escape(p.label)}": ROLE_COLOURS[p.role] for p in roles(description)}
    page: str = displacy.render(
        marked, style="ent", manual=True, page=True, jupyter=False, options={"colors": colours}
    )
    return page.replace("</body>", f"{_table(description)}\n</body>")


def _table(description: Description) -> str:
    """Return the relations as an HTML table, and what was not understood as a list."""
    rows = [
        "<tr>"
        + "".join(
            f"<td>{escape(cell)}</td>"
            for cell in (
                relation.figure,
                f"not {relation.relation}" if relation.negated else relation.relation,
                part_in_words(relation.part, ", ".join(relation.grounds)),
                "" if relation.distance_m is None else f"{relation.distance_m:g} m",
                f"{relation.confidence:.2f}",
            )
        )
        + "</tr>"
        for relation in description.relations
    ]
    head = "".join(
        f"<th>{name}</th>" for name in ("figure", "relation", "ground", "distance", "confidence")
    )
    missed = [
        f"<li>{escape(_shown(u.text))}"
        + (f" (nearest: {escape(', '.join(u.candidates))})" if u.candidates else "")
        + "</li>"
        for u in description.unresolved
    ]
    listed = f"<p>Not understood:</p><ul>{''.join(missed)}</ul>" if missed else ""
    return f'<table border="1" cellpadding="4"><tr>{head}</tr>{"".join(rows)}</table>{listed}'


def _shown(text: str) -> str:
    return text.encode("utf-8", "replace").decode("utf-8")

"""Say why a planner chose what it chose: values, visits and what each move would show."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sloop_ppl.bridge.relation_text import percent

if TYPE_CHECKING:
    from sloop_ppl.planning import Step

__all__ = ["why_lines"]


def why_lines(step: Step) -> list[str]:
    """Return a line for each action that the planner could take, the chosen one marked.

    Parameters
    ----------
    step
        A step of a search.
    """
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

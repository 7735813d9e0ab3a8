"""What a speaker could have said of a ground: one relation word for each meaning."""

from __future__ import annotations

__all__ = ["SPEAKER_WORDS"]

SPEAKER_WORDS = (
    "at",
    "near",
    "north",
    "northeast",
    "east",
    "southeast",
    "south",
    "southwest",
    "west",
    "northwest",
    "front",
    "behind",
    "left",
    "right",
)
"""Relation words a simulated speaker chooses from, one per meaning that models tell apart."""

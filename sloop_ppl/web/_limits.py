"""What a request may ask for at most."""

from __future__ import annotations

__all__ = [
    "MOST_BODY_BYTES",
    "MOST_CELLS",
    "MOST_CORNERS",
    "MOST_EPISODE_BYTES",
    "MOST_PLAYED_STEPS",
    "MOST_SIMS",
    "MOST_STEPS",
    "MOST_STREAMS",
    "MOST_TEXT",
    "MOST_UPLOADS",
    "MOST_UPLOAD_BYTES",
    "SECONDS_FOR_A_BODY",
    "SECONDS_FOR_A_FILE",
]

MOST_TEXT = 2_000
"""Characters of a text."""

MOST_BODY_BYTES = 64 * 2**10
"""Bytes of a request, but for a map."""

MOST_UPLOAD_BYTES = 48 * 2**20
"""Bytes of a map file."""

MOST_UPLOADS = 16
"""Maps that were dropped in and are kept; of more the one used longest ago is forgotten."""

MOST_CELLS = 160_000
"""Cells of a map: two kilometres a side in cells of 5 m."""

MOST_CORNERS = 200
"""Corners of a search area."""

MOST_EPISODE_BYTES = 24 * 2**20
"""Bytes of an episode file."""

MOST_STEPS = 1_000
"""Steps of a search."""

MOST_PLAYED_STEPS = 2_000
"""Steps of an episode that is opened."""

MOST_SIMS = 10_000
"""Simulations a step."""

MOST_STREAMS = 8
"""Searches that run at a time."""

SECONDS_FOR_A_BODY = 20.0
"""How long the body of a request may take to come."""

SECONDS_FOR_A_FILE = 120.0
"""How long a map or an episode may take to be read."""

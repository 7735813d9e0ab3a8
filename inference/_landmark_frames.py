"""Tell which way the landmarks of a map face, and word it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.models import GroundedRelation
from sloop_ppl.models.frames import FrameDistribution, LearnedFrames, frame_predictor

__all__ = ["frame_lines", "frame_report", "frames_of"]


def frames_of(
    city: CityMap, frames: str = "ego-ctx", landmarks: Sequence[str] | None = None
) -> dict[str, FrameDistribution]:
    """Return which way landmarks of a map face, by their id.

    Parameters
    ----------
    frames
        A registered frame predictor, or the path of a weights file.
    landmarks
        Ids; all buildings when None or empty.

    Raises
    ------
    UnknownName
        For another predictor, or a landmark that is not on the map.
    InputError
        When the map has no building and no landmark is given, or weights cannot be used.
    """
    predictor = frame_predictor(frames)
    wanted = list(landmarks or [b.id for b in city.of_kind("building")])
    if not wanted:
        raise InputError(f"Map '{city.name}' has no building; name a landmark of it")
    terms = [GroundedRelation("front", (city.landmark(i).id,), city) for i in wanted]
    if isinstance(predictor, LearnedFrames):  # draws and looks at all of them at once
        predictor.predict(city, [t.ground for t in terms if not t.is_line])
    return {term.ground: predictor(term) for term in terms}


def frame_report(
    city: CityMap, frames: str, frames_by_landmark: Mapping[str, FrameDistribution]
) -> dict[str, Any]:
    """Return the value that ``sloop frames predict --json`` prints."""
    return {
        "map": city.name,
        "frames": frames,
        "landmarks": {
            name: {
                "mode_deg": [_degrees(angle) for angle in distribution.modes()],
                "parts": [
                    {
                        "mean_deg": _degrees(part.mean_rad),
                        "kappa": None if math.isinf(part.kappa) else part.kappa,
                        "p": part.weight,
                    }
                    for part in distribution.parts
                ],
                "lapse": distribution.lapse,
            }
            for name, distribution in frames_by_landmark.items()
        },
    }


def frame_lines(frames_by_landmark: Mapping[str, FrameDistribution]) -> list[str]:
    """Return a line a landmark: its fronts in degrees from east, how sure, and the lapse."""
    lines = []
    for name, distribution in frames_by_landmark.items():
        parts = [
            f"{_degrees(part.mean_rad):.0f}° p {part.weight:.2f}"
            + ("" if math.isinf(part.kappa) else f" (kappa {part.kappa:.0f})")
            for part in distribution.parts
        ]
        lines.append(f"{name}: {', '.join([*parts, f'anywhere p {distribution.lapse:.2f}'])}")
    return lines


def _degrees(angle_rad: float) -> float:
    return math.degrees(math.remainder(angle_rad, 2 * math.pi))

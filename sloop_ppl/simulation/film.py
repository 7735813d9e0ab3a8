"""A film of a flown search: the chase view with the camera's picture in it, and the belief map."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import OutputError
from sloop_ppl.outputs import written_whole
from sloop_ppl.planning.episode import Episode
from sloop_ppl.plots import check_figure_path, search_frames
from sloop_ppl.plots._video_files import find_ffmpeg, write_gif, write_mp4
from sloop_ppl.simulation.camera import Camera
from sloop_ppl.simulation.detectors import Detection
from sloop_ppl.simulation.drone import Drone
from sloop_ppl.simulation.looks import COLOURS
from sloop_ppl.simulation.world import World

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["Film", "camera_panel", "check_film_path"]

_CHASE = (640, 480)
_INSET_WIDTH = 220
_EDGE = 3
_EVERY_S = 0.5
_FPS = 8.0
_LIGHTS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1)


def check_film_path(path: str | Path) -> Path:
    """Return the path when a film can be written there, before anything is flown.

    Raises
    ------
    InputError, OutputError
        When the ending is neither .mp4 nor .gif, ffmpeg is missing for an .mp4, or the folder is.
    """
    chosen = check_figure_path(path, animation=True)
    if chosen.suffix.lower() == ".mp4":
        find_ffmpeg()
    return chosen


class Film:
    """Pictures of a flight, taken twice a simulated second.

    Parameters
    ----------
    camera
        The drone's camera, which also draws the chase view.
    """

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self._shots: list[tuple[int, bytes]] = []
        self._looks: list[bytes] = []
        camera.drone.watch(self._shoot, _EVERY_S)
        self._shoot(camera.drone)

    def look(self, detections: Sequence[Detection]) -> None:
        """Keep what the camera sees after a step, with what was detected."""
        picture = camera_panel(self._camera.picture(), self._camera.world, detections)
        self._looks.append(_packed(picture))
        self._shoot(self._camera.drone)

    def write(self, path: str | Path, episode: Episode, *, fps: float = _FPS) -> Path:
        """Write the film, each belief beside the flight that it led to.

        Parameters
        ----------
        path
            Where to write it; it ends in .gif or .mp4.
        episode
            The search, with its beliefs.
        fps
            Pictures a second, > 0; 8 show the flight four times as quick as it was.

        Raises
        ------
        OutputError
            When it cannot be written.
        """
        chosen = check_film_path(path)
        city = self._camera.world.city
        maps = search_frames(episode, city, imagined=episode.imagined)
        frames = [
            self._frame(_unpacked(shot), step, maps[min(step, len(maps) - 1)])
            for step, shot in self._shots
        ]
        try:
            with written_whole(chosen) as whole:
                if chosen.suffix.lower() == ".mp4":
                    write_mp4(frames, whole, fps, find_ffmpeg())
                else:
                    write_gif(frames, whole, fps, self._colours())
        except OutputError:
            raise
        except OSError as error:
            raise OutputError(
                f"Film '{path}' cannot be written: {error.strerror or error}"
            ) from error
        return chosen

    def _colours(self) -> list[tuple[int, int, int]]:
        """Return the colours of the targets from shade to sun, which a GIF must not change."""
        looks = self._camera.world.looks.values()
        return [
            (_tone(red, light), _tone(green, light), _tone(blue, light))
            for red, green, blue in sorted({COLOURS[look.colour] for look in looks})
            for light in _LIGHTS
        ]

    def _shoot(self, drone: Drone) -> None:  # noqa: ARG002 - what watchers are called with
        picture = _image(self._camera.chase(*_CHASE))
        self._shots.append((len(self._looks), _packed(picture)))

    def _frame(self, shot: Image, step: int, belief: Image) -> Image:
        from PIL import Image as Pictures
        from PIL import ImageOps

        wide = round(belief.width * _CHASE[1] / belief.height)
        frame = Pictures.new("RGB", ((_CHASE[0] + wide) // 2 * 2, _CHASE[1]), "white")
        frame.paste(shot, (0, 0))
        if step:
            look = _unpacked(self._looks[min(step, len(self._looks)) - 1])
            high = round(look.height * _INSET_WIDTH / look.width)
            inset = ImageOps.expand(look.resize((_INSET_WIDTH, high)), _EDGE, "white")
            frame.paste(inset, (_CHASE[0] - inset.width - 9, _CHASE[1] - inset.height - 9))
        frame.paste(belief.resize((wide, _CHASE[1]), Pictures.Resampling.LANCZOS), (_CHASE[0], 0))
        return frame


def camera_panel(
    picture: NDArray[np.uint8], world: World, detections: Sequence[Detection]
) -> Image:
    """Return a camera's picture with a box and the name around each target that was detected."""
    from PIL import ImageDraw, ImageFont

    image: Image = _image(picture)
    draw, size = ImageDraw.Draw(image), max(10, image.width // 22)  # is read in a small inset too
    font = ImageFont.load_default(size)
    for found in detections:
        if found.box is None:
            continue
        left, top, right, bottom = found.box
        colour = tuple(round(255 * c) for c in COLOURS[world.looks[found.target].colour])
        line = max(2, image.width // 150)
        for grow, paint in ((line + 2, "white"), (line + 1, colour)):
            draw.rectangle(
                (left - grow, top - grow, right + grow, bottom + grow), outline=paint, width=line
            )
        wide = draw.textlength(found.target, font=font) + 8
        above = top - 4 - size * 1.3
        low = above if above >= 0 else min(bottom + 4, image.height - size * 1.3)
        at = min(max(left - 4, 0), max(image.width - wide, 0))
        draw.rectangle((at, low, at + wide, low + size * 1.3), fill="white")
        draw.text((at + 4, low), found.target, fill="black", font=font)
    return image


def _tone(part: float, light: float) -> int:
    return min(round(255 * part * light), 255)


def _image(pixels: NDArray[np.uint8]) -> Any:
    from PIL import Image as Pictures

    return Pictures.fromarray(pixels)


def _packed(picture: Image) -> bytes:
    # A flight has hundreds of pictures: kept as JPEG they take a twentieth of the memory.
    buffer = io.BytesIO()
    picture.save(buffer, "JPEG", quality=92)
    return buffer.getvalue()


def _unpacked(data: bytes) -> Image:
    from PIL import Image as Pictures

    return Pictures.open(io.BytesIO(data)).convert("RGB")

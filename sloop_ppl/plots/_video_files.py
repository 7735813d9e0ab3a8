"""Write a sequence of pictures as a GIF or, through ffmpeg, as an MP4."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.plots._palette import ACCENTS, INK, PAPER

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["find_ffmpeg", "write_gif", "write_mp4"]

# With accents, paper and ink below the 256 colours that a GIF has.
_COLOURS = 160
_KEPT = 80
_LAST_FRAME_S = 2.0


def find_ffmpeg() -> str:
    """Return the path of the ffmpeg program that matplotlib is set to use.

    Raises
    ------
    InputError
        When there is none; install it or write a GIF.
    """
    import shutil

    import matplotlib as mpl

    found: str | None = shutil.which(mpl.rcParams["animation.ffmpeg_path"])
    if found is None:
        raise InputError(
            "An .mp4 animation needs the program ffmpeg, which was not found; install it or "
            "choose an animation path that ends in .gif"
        )
    return found


def write_gif(
    frames: Sequence[Image],
    path: Path,
    fps: float,
    colours: Sequence[tuple[int, int, int]] = (),
) -> None:
    """Write frames as a GIF that loops, all in one palette: their own colours and the accents.

    Parameters
    ----------
    frames
        RGB pictures of equal size, at least one.
    fps
        Frames a second, > 0; the last frame stays for two seconds.
    colours
        Red, green and blue from 0 to 255 of up to 80 further colours that must stay as they are.
    """
    from matplotlib.colors import to_rgb
    from PIL import Image as Pictures

    # The first, middle and last frame hold all colours that occur: belief wide and narrow.
    picked = [frames[i] for i in sorted({0, len(frames) // 2, len(frames) - 1})]
    sheet = Pictures.fromarray(np.concatenate([np.asarray(f) for f in picked]))
    # One palette for all frames, else colours would flicker; no dithering, which does not compress.
    common = sheet.quantize(_COLOURS, method=Pictures.Quantize.MEDIANCUT).getpalette() or []
    signal = [round(255 * c) for name in (*ACCENTS.values(), PAPER, INK) for c in to_rgb(name)]
    palette = Pictures.new("P", (1, 1))
    kept = [part for colour in colours[:_KEPT] for part in colour]
    palette.putpalette((*common[: 3 * _COLOURS], *signal, *kept))
    still = [f.quantize(palette=palette, dither=Pictures.Dither.NONE) for f in frames]
    durations = [round(1000 / fps)] * len(still)
    durations[-1] = round(1000 * _LAST_FRAME_S)
    still[0].save(
        path,
        format="GIF",
        save_all=True,
        append_images=still[1:],
        duration=durations,
        loop=0,
        disposal=1,
        optimize=False,
    )


def write_mp4(frames: Sequence[Image], path: Path, fps: float, ffmpeg: str) -> None:
    """Write frames as an MP4 that holds neither dates nor the encoder's version.

    Parameters
    ----------
    frames
        RGB pictures of equal and even size, at least one.

    Raises
    ------
    OutputError
        When ffmpeg fails; the message ends with what it said last.
    """
    width, height = frames[0].size
    # One thread and bitexact: the same bytes for the same pictures. yuv420p plays everywhere and
    # needs even sides.
    command = [
        ffmpeg, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-", "-an", "-pix_fmt", "yuv420p",
        "-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact",
        "-map_metadata", "-1", str(path),
    ]  # fmt: skip
    raw = b"".join(f.tobytes() for f in frames)
    done = subprocess.run(command, input=raw, capture_output=True, check=False)
    if done.returncode != 0:
        messages = done.stderr.decode(errors="replace").strip().splitlines() or ["nothing"]
        raise OutputError(f"The animation cannot be written; ffmpeg said: {messages[-1]}")

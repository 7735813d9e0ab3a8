"""MuJoCo, imported when it is first needed, with the way of rendering that this machine has."""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from importlib.util import find_spec
from typing import Any

from sloop_ppl.errors import InputError, on_one_line

__all__ = ["GL_PACKAGES", "mujoco", "rendering_fault"]

GL_PACKAGES = "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)"
"""What brings headless rendering to Debian."""

# What the loader calls the libraries; find_library would run a compiler to look for them.
_LIBRARIES = {"egl": ("libEGL.so.1",), "osmesa": ("libOSMesa.so.8", "libOSMesa.so.6")}


@cache
def mujoco() -> Any:
    """Return the module `mujoco`, or say how to get it.

    Raises
    ------
    InputError
        When it is not installed, or cannot be imported, as with a MUJOCO_GL that it does not know.

    Notes
    -----
    How pictures are made is settled by the environment variable MUJOCO_GL when `mujoco` is first
    imported. Where nobody has set it, it is set here: EGL where its library is, else OSMesa, else
    nothing, for rays and flight need no pictures.
    """
    if find_spec("mujoco") is None:
        raise InputError(
            "The simulator needs mujoco, which is not installed; run pip install 'sloop-ppl[sim]'"
        )
    if "mujoco" not in sys.modules and "MUJOCO_GL" not in os.environ and sys.platform == "linux":
        os.environ["MUJOCO_GL"] = next((name for name in _LIBRARIES if _has(name)), "disable")
    try:
        import mujoco as module
    except Exception as error:  # drivers fail in many ways; a MUJOCO_GL it does not know is one
        chosen = os.environ.get("MUJOCO_GL", "")
        raise InputError(
            f"mujoco cannot be imported with MUJOCO_GL={chosen}: {on_one_line(str(error))}; unset "
            "it, or set it to egl, osmesa or disable"
        ) from error
    return module


def rendering_fault() -> str:
    """Return why no pictures can be made here; empty where they can."""
    mujoco()
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    if chosen in _LIBRARIES:
        return "" if _has(chosen) else f"MUJOCO_GL is {chosen}, of which the library is missing"
    if chosen in ("disable", "disabled", "off", "false", "0"):
        if any(map(_has, _LIBRARIES)):
            return f"MUJOCO_GL is {chosen}; unset it"
        return "there is neither EGL nor OSMesa"
    screens = {"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ)
    if sys.platform == "linux" and not screens:
        return f"MUJOCO_GL is {chosen}, which needs a screen; set it to egl or osmesa"
    return ""


@cache
def _has(name: str) -> bool:
    """Tell whether one of the libraries of a way of rendering can be loaded."""
    for library in _LIBRARIES[name]:
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        return True
    return False

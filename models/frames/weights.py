"""Save a trained frame network as safetensors and load it, refusing what is of another version."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save

from sloop_ppl.errors import InputError
from sloop_ppl.models.frames.network import FrameNetwork, NetworkShape
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["WEIGHTS_VERSION", "TrainedFrames", "load_weights", "save_weights"]

WEIGHTS_VERSION = "sloop-frames 1"
"""What a weights file says it is. Another picture, list of streets or network is another one."""

_ENDING = ".safetensors"
_ENTRY = "sloop_frames"


@dataclass(frozen=True, eq=False)
class TrainedFrames:
    """A trained network, ready to predict.

    Parameters
    ----------
    network : in evaluation mode.
    about : how it was made: ``name``, ``trained_on``, ``command``, figures; all text.
    """

    network: FrameNetwork
    about: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))


def save_weights(trained: TrainedFrames, path: str | Path) -> None:
    """Write a network and how it was made, all of it or nothing.

    Raises
    ------
    OutputError : when the path cannot be written or does not end in ``.safetensors``.
    """
    check_output(path, (_ENDING,))
    told = {
        **trained.about,
        "version": WEIGHTS_VERSION,
        "shape": dataclasses.asdict(trained.network.shape),
    }
    state = {name: t.detach().contiguous() for name, t in trained.network.state_dict().items()}
    with written_whole(path) as temporary:
        # One entry, since safetensors writes several in no fixed order: same seed, same bytes.
        temporary.write_bytes(save(state, {_ENTRY: json.dumps(told, sort_keys=True)}))


def load_weights(path: str | Path) -> TrainedFrames:
    """Read what `save_weights` wrote.

    Raises
    ------
    InputError : when the file cannot be read, is no weights file, is of another version (which
        the message names), or holds NaN.
    """
    try:
        with safe_open(str(path), framework="pt") as file:
            told: dict[str, Any] = json.loads((file.metadata() or {}).get(_ENTRY, "{}"))
            state = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except FileNotFoundError as error:
        raise InputError(f"Weights '{path}' do not exist; expected a {_ENDING} file") from error
    except (OSError, ValueError, SafetensorError) as error:
        raise InputError(f"Weights '{path}' are no safetensors file: {error}") from error
    found = told.get("version", "none")
    if found != WEIGHTS_VERSION:
        raise InputError(
            f"Weights '{path}' are of version '{found}'; expected '{WEIGHTS_VERSION}'; train them "
            "again with `sloop frames train`"
        )
    try:
        network = FrameNetwork(_shape(told["shape"]))
        network.load_state_dict(state)
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        reason = str(error).split("\n")[0]
        raise InputError(f"Weights '{path}' do not fit their network: {reason}") from error
    if not all(bool(torch.isfinite(t).all()) for t in state.values()):
        raise InputError(f"Weights '{path}' hold NaN or infinite numbers; train them again")
    network.eval()
    about = {k: v for k, v in told.items() if k not in ("version", "shape")}
    return TrainedFrames(network, MappingProxyType(about))


def _shape(told: dict[str, Any]) -> NetworkShape:
    lists: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in told.items()}
    return NetworkShape(**lists)

"""Networks that look at a picture of a landmark and tell which way it faces, and their files."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

import torch
from msgspec import Meta, Struct
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor, nn

from sloop_ppl._foreign import parse_json
from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError
from sloop_ppl.models.frames._pictures import PLANES
from sloop_ppl.models.frames._streets import FEATURES
from sloop_ppl.outputs import check_output, written_whole

__all__ = [
    "DIRECTIONS",
    "WEIGHTS_VERSION",
    "FrameNetwork",
    "NetworkShape",
    "Outputs",
    "TrainedFrames",
    "load_weights",
    "log_density",
    "save_weights",
]

DIRECTIONS = 24
"""Directions that the picture itself speaks for, the first east, anticlockwise."""

_KAPPA_RANGE = (0.5, 1000.0)  # from all but uniform to a deviation of 1.8 degrees
_TURNS = 4  # by right angles: what is seen turns with the picture, whatever the weights
_AT_ONCE = 32  # so many pictures in their four turns stay in the processor's cache

WEIGHTS_VERSION = "sloop-frames 1"
"""What a weights file says it is. Another picture, list of streets or network is another one."""

_ENDING = ".safetensors"
_ENTRY = "sloop_frames"


@dataclass(frozen=True)
class NetworkShape:
    """What a network is made of.

    Parameters
    ----------
    view
        The picture it looks at; see :data:`sloop_ppl.models.frames.VIEWS`.
    channels
        Channels of the two convolutions. 28 pixels shrink to 5 x 5, so 32 channels in the second
        make the paper's 800 features.
    hidden
        Widths of the first two dense layers.
    streets
        True to weigh the streets around too, each by its own few facts.
    angle
        True for the paper's output, one angle; False for a distribution.
    greys
        True for the paper's one grey picture; False for four planes.
    """

    view: str = "ego-ctx"
    channels: tuple[int, int] = (8, 32)
    hidden: tuple[int, int] = (64, 32)
    streets: bool = True
    angle: bool = False
    greys: bool = False


Width = Annotated[int, Meta(ge=1, le=1024, description="a number from 1 to 1024")]
Widths = Annotated[tuple[Width, Width], Meta(description="two numbers from 1 to 1024")]


class _ShapeRecord(Struct):
    """A `NetworkShape` as a file holds it."""

    view: str
    channels: Widths
    hidden: Widths
    streets: bool
    angle: bool
    greys: bool


@dataclass(frozen=True, eq=False)
class Outputs:
    """What a network says of N landmarks: parts of a mixture, and a lapse.

    Parameters
    ----------
    mean_rad
        Shape (N, P), radians.
    kappa
        Shape (N, P).
    log_weight
        Shape (N, P + 1), the last one that of the lapse; each row sums to one in probability.
    """

    mean_rad: Tensor
    kappa: Tensor
    log_weight: Tensor


class FrameNetwork(nn.Module):
    """Two convolution modules and three dense layers, and a small scorer of streets.

    Parameters
    ----------
    shape
        What it is made of.

    Notes
    -----
    Source: SLOOP sec. IV-C for the layers and the 800 features. Ours: the mixture it puts out, and
    the streets as further parts of it, whose logit adds what the picture says of their direction
    to what a small network says of their facts. That sum does not depend on the order of streets.
    """

    directions: Tensor
    turned: Tensor

    def __init__(self, shape: NetworkShape) -> None:
        super().__init__()
        self.shape = shape
        first, second = shape.channels
        planes = 1 if shape.greys or shape.view == "ego" else len(PLANES)
        self.look = nn.Sequential(
            nn.Conv2d(planes, first, 3), nn.ReLU(), nn.MaxPool2d(2),
            nn.Conv2d(first, second, 3), nn.ReLU(), nn.MaxPool2d(2),
            nn.Flatten(),
        )  # fmt: skip
        out = 2 if shape.angle else DIRECTIONS + 2
        self.dense = nn.Sequential(
            nn.Linear(25 * second, shape.hidden[0]), nn.ReLU(), nn.Dropout(0.2),
            nn.Linear(shape.hidden[0], shape.hidden[1]), nn.ReLU(),
            nn.Linear(shape.hidden[1], out),
        )  # fmt: skip
        self.weigh = (
            nn.Sequential(nn.Linear(len(FEATURES), 24), nn.ReLU(), nn.Linear(24, 1))
            if shape.streets
            else None
        )
        self.log_kappa = nn.Parameter(torch.tensor([math.log(8.0), math.log(100.0)]))
        self.angle_lapse = nn.Parameter(torch.tensor(-2.0), requires_grad=False)
        at = torch.arange(DIRECTIONS, dtype=torch.float32)
        turn = torch.arange(_TURNS)[:, None] * (DIRECTIONS // _TURNS)
        self.register_buffer("directions", at * (2 * math.pi / DIRECTIONS), persistent=False)
        self.register_buffer("turned", (at.long() + turn) % DIRECTIONS, persistent=False)

    def forward(
        self, pictures: Tensor, bearing_rad: Tensor, features: Tensor, there: Tensor
    ) -> Outputs:
        """Return the mixture of each landmark.

        Parameters
        ----------
        pictures
            Planes, shape (N, 4, 28, 28).
        bearing_rad
            Directions to streets, shape (N, C).
        features
            Facts of the streets, shape (N, C, F).
        there
            False where a row has fewer than C streets, shape (N, C).
        """
        return self._mixture(
            self.dense(self.look(self._seen(pictures))), bearing_rad, features, there
        )

    def averaged(
        self, pictures: Tensor, bearing_rad: Tensor, features: Tensor, there: Tensor
    ) -> Outputs:
        """Return the mixture of each landmark, its picture seen in its four quarter turns.

        Parameters
        ----------
        pictures, bearing_rad, features, there
            As `forward` takes them.

        Returns
        -------
        Outputs
            The mean of the four mixtures, with the parts of `forward`. An angle network gives four
            parts instead, one for each turn.
        """
        outputs = torch.cat(
            [self._turned(some) for some in self._seen(pictures).split(_AT_ONCE)], 1
        )
        made = self._mixture(outputs, bearing_rad, features, there)
        if not self.shape.angle:
            weight = made.log_weight.exp().mean(0).log()
            return Outputs(made.mean_rad, made.kappa, weight)
        share = made.log_weight[:, :, 0].T - math.log(_TURNS)
        lapse = made.log_weight[0, :, 1:]
        return Outputs(made.mean_rad[..., 0].T, made.kappa[..., 0].T, torch.cat([share, lapse], 1))

    def _turned(self, seen: Tensor) -> Tensor:
        """Return what is told of the quarter turns, as directions of what is not turned."""
        rows = seen.permute(0, 2, 3, 1).contiguous()  # channels last takes a third of the time
        turned = torch.cat([torch.rot90(rows, -turn, (1, 2)) for turn in range(_TURNS)])
        outputs: Tensor = self.dense(self.look(turned.permute(0, 3, 1, 2)))
        outputs = outputs.unflatten(0, (_TURNS, -1))
        if self.shape.angle:
            quarters = [(1, 0, 0, 1), (0, -1, 1, 0), (-1, 0, 0, -1), (0, 1, -1, 0)]
            return outputs @ outputs.new_tensor(quarters).reshape(_TURNS, 2, 2)
        back = self.turned[:, None].expand(-1, len(seen), -1)
        return torch.cat([outputs.gather(-1, back), outputs[..., DIRECTIONS:]], -1)

    def _mixture(
        self, outputs: Tensor, bearing_rad: Tensor, features: Tensor, there: Tensor
    ) -> Outputs:
        """Return the mixtures for what the pictures tell, shape (N, ...) or (T, N, ...)."""
        low, high = _KAPPA_RANGE
        kappa = self.log_kappa.exp().clamp(low, high)
        if self.shape.angle:
            mean = torch.atan2(outputs[..., 1:], outputs[..., :1])
            flat = torch.zeros_like(mean)
            weights = torch.log_softmax(torch.cat([flat, flat + self.angle_lapse], -1), -1)
            return Outputs(mean, kappa[0].expand_as(mean), weights)
        directions = self.directions.expand(outputs.shape[-2], -1)
        logits, mean, spread = outputs[..., :DIRECTIONS], directions, kappa[0].expand_as(directions)
        lapse = outputs[..., DIRECTIONS : DIRECTIONS + 1]
        if self.weigh is not None:
            alike = torch.cos(bearing_rad[..., None] - directions[:, None, :])
            # Kappa 12, a deviation of 17 degrees, takes in the direction on either side, 15 apart.
            liked = (torch.softmax(12.0 * alike, -1) * logits[..., None, :]).sum(-1)
            scores = self.weigh(features)[..., 0] + liked
            scores = scores.masked_fill(~there, -math.inf)
            # Before training a street weighs e^3 = 20 times a direction without one, or the lapse.
            free = logits - 3.0 + outputs[..., DIRECTIONS + 1 :]
            logits = torch.cat([free, scores], -1)
            mean = torch.cat([directions, bearing_rad], 1)
            spread = torch.cat([spread, kappa[1].expand_as(bearing_rad)], 1)
            lapse = lapse - 3.0
        return Outputs(mean, spread, torch.log_softmax(torch.cat([logits, lapse], -1), -1))

    def _seen(self, pictures: Tensor) -> Tensor:
        """Return what the first convolution takes: four planes, the ground alone, or one grey."""
        if self.shape.greys:
            ground, streets, paths, buildings = pictures.unbind(1)
            ways = torch.maximum(streets, paths)
            grey = torch.where(ways >= 0.5, 0.7, torch.where(buildings >= 0.5, 0.35, 0.0))
            return torch.where(ground >= 0.5, 1.0, grey)[:, None]
        return pictures[:, :1] if self.shape.view == "ego" else pictures


def log_density(outputs: Outputs, angle_rad: Tensor) -> Tensor:
    """Return the log density per radian of an angle under each mixture, shape (N,)."""
    log_i0 = torch.log(torch.special.i0e(outputs.kappa))
    parts = outputs.kappa * (torch.cos(angle_rad[:, None] - outputs.mean_rad) - 1) - log_i0
    uniform = torch.zeros_like(outputs.log_weight[:, -1:])
    return torch.logsumexp(outputs.log_weight + torch.cat([parts, uniform], 1), 1) - math.log(
        2 * math.pi
    )


@dataclass(frozen=True, eq=False)
class TrainedFrames:
    """A trained network, ready to predict.

    Parameters
    ----------
    network
        Network in evaluation mode.
    about
        How it was made: ``name``, ``trained_on``, ``command``, figures; all text.
    """

    network: FrameNetwork
    about: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))


def save_weights(trained: TrainedFrames, path: str | Path) -> None:
    """Write a network and how it was made, all of it or nothing.

    Raises
    ------
    OutputError
        When the path cannot be written or does not end in ``.safetensors``.
    """
    check_output(path, (_ENDING,))
    metadata = {
        **trained.about,
        "version": WEIGHTS_VERSION,
        "shape": dataclasses.asdict(trained.network.shape),
    }
    state = {name: t.detach().contiguous() for name, t in trained.network.state_dict().items()}
    with written_whole(path) as temporary:
        # One entry, since safetensors writes several in no fixed order: same seed, same bytes.
        temporary.write_bytes(save(state, {_ENTRY: json.dumps(metadata, sort_keys=True)}))


def load_weights(path: str | Path) -> TrainedFrames:
    """Read what `save_weights` wrote.

    Raises
    ------
    InputError
        When the file cannot be read, is no weights file, is of another version (which the message
        names), or holds NaN.
    """
    try:
        with safe_open(str(path), framework="pt") as file:
            metadata: Any = parse_json((file.metadata() or {}).get(_ENTRY, "{}"))
            state = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except FileNotFoundError as error:
        raise InputError(f"Weights '{path}' do not exist; expected a {_ENDING} file") from error
    except (OSError, ValueError, TypeError, RuntimeError, SafetensorError) as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"Weights '{path}' are no safetensors file: {reason}") from error
    if not isinstance(metadata, dict):
        raise InputError(f"Weights '{path}' do not say what they are; train them again")
    found = metadata.get("version", "none")
    if found != WEIGHTS_VERSION:
        raise InputError(
            f"Weights '{path}' are of version '{found}'; expected '{WEIGHTS_VERSION}'; train them "
            "again with `sloop frames train`"
        )
    try:
        network = FrameNetwork(_shape(metadata["shape"]))
        network.load_state_dict(state)
    except (Fault, KeyError, TypeError, ValueError, RuntimeError, OverflowError) as error:
        reason = str(error).split("\n")[0]
        raise InputError(f"Weights '{path}' do not fit their network: {reason}") from error
    if not all(bool(torch.isfinite(t).all()) for t in state.values()):
        raise InputError(f"Weights '{path}' hold NaN or infinite numbers; train them again")
    network.eval()
    about = {k: v for k, v in metadata.items() if k not in ("version", "shape")}
    return TrainedFrames(network, MappingProxyType(about))


def _shape(record: object) -> NetworkShape:
    """Return the shape of a network, no larger than memory for it can be had."""
    made = checked(record, _ShapeRecord)
    return NetworkShape(**{name: getattr(made, name) for name in made.__struct_fields__})

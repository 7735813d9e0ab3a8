"""Draws of a model's parameters from their posterior, and what sums them up."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from pyro.ops.stats import effective_sample_size, split_gelman_rubin

from sloop_ppl._foreign import parse_json, read_text
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference._draws import import_arviz
from sloop_ppl.models import ObservationModel
from sloop_ppl.models.tuning import with_parameters
from sloop_ppl.outputs import check_output, written_whole

if TYPE_CHECKING:
    import xarray

__all__ = ["ParameterDraws", "ParameterSummary"]

_BY_SPEAKER = "_by_speaker"


@dataclass(frozen=True)
class ParameterSummary:
    """One number, summed up.

    Parameters
    ----------
    name
        Variable, with its component or speaker in brackets where it has one.
    median
        Median of the draws.
    low, high
        Ends of the central 95 %.
    r_hat
        Split r-hat; above 1.01 the chains do not agree yet.
    ess
        Effective number of draws.
    """

    name: str
    median: float
    low: float
    high: float
    r_hat: float
    ess: float


@dataclass(frozen=True, eq=False)
class ParameterDraws:
    """Draws of a model's parameters.

    Parameters
    ----------
    model
        Name of the model they are of.
    dataset
        One variable per parameter with dims chain and draw and the attribute ``section``;
        ``weights`` has the dim component too. Where parameters vary from speaker to speaker,
        ``NAME`` is the population's, ``NAME_by_speaker`` has the dim speaker, and ``NAME_spread``
        is the standard deviation between speakers of the log of the value (its log odds, where the
        range is finite).
    provenance
        Seed, numbers of examples, targets, speakers, chains, draws and divergences, what was drawn
        from, and versions.
    """

    model: str
    dataset: xarray.Dataset
    provenance: Mapping[str, Any] = field(default_factory=dict)

    @property
    def speakers(self) -> tuple[str, ...]:
        """Names of the speakers that parameters vary between; none when they do not."""
        coords = self.dataset.coords
        return tuple(map(str, coords["speaker"].values)) if "speaker" in coords else ()

    @property
    def parameters(self) -> dict[str, dict[str, float]]:
        """Posterior medians of the population's, as ``with_parameters`` takes parameters."""
        return self._medians({})

    def parameters_of(self, speaker: str) -> dict[str, dict[str, float]]:
        """Return the posterior medians of one speaker.

        Raises
        ------
        UnknownName
            When nothing was drawn for a speaker of this name.
        """
        if speaker not in self.speakers:
            raise UnknownName("speaker", speaker, self.speakers)
        return self._medians({"speaker": speaker})

    def apply(self, model: ObservationModel, speaker: str | None = None) -> ObservationModel:
        """Return a model with the medians: the population's, or a speaker's."""
        values = self.parameters if speaker is None else self.parameters_of(speaker)
        return with_parameters(model, values)

    @property
    def summary(self) -> tuple[ParameterSummary, ...]:
        """Every number with its median, central 95 %, split r-hat and effective draws."""
        rows = []
        for name, array in self.dataset.data_vars.items():
            extra = [dim for dim in array.dims if dim not in ("chain", "draw")]
            for index in np.ndindex(*(array.sizes[dim] for dim in extra)):
                one = array.isel(dict(zip(extra, index, strict=True)))
                inside = ", ".join(str(one[dim].values) for dim in extra)
                rows.append(_summed(f"{name}[{inside}]" if extra else str(name), one))
        return tuple(rows)

    @property
    def r_hat(self) -> dict[str, float]:
        """Split r-hat of each number."""
        return {row.name: row.r_hat for row in self.summary}

    @property
    def ess(self) -> dict[str, float]:
        """Effective number of draws of each number."""
        return {row.name: row.ess for row in self.summary}

    def __str__(self) -> str:
        """Return the summary as a table."""
        width = max(len(row.name) for row in self.summary)
        head = f"{'':{width}} {'median':>9} {'2.5 %':>9} {'97.5 %':>9} {'r-hat':>6} {'ess':>6}"
        lines = [
            f"{row.name:{width}} {row.median:9.4g} {row.low:9.4g} {row.high:9.4g} "
            f"{row.r_hat:6.3f} {row.ess:6.0f}"
            for row in self.summary
        ]
        return "\n".join([head, *lines])

    def to_arviz(self) -> Any:
        """Return an ArviZ InferenceData whose group ``posterior`` holds the draws.

        Raises
        ------
        InputError
            When ArviZ is not installed, or is a version without InferenceData.
        """
        attrs = {"inference_library": "sloop_ppl", "model": self.model}
        return import_arviz().InferenceData(posterior=self.dataset.assign_attrs(attrs))

    def save(self, path: str | Path) -> None:
        """Write medians, summary and draws as JSON, which ``--params`` and `load` read.

        Raises
        ------
        OutputError
            When the file cannot be written, or does not end in .json.
        """
        check_output(path, (".json",))
        payload = {
            "model": self.model,
            "parameters": self.parameters,
            "speakers": {speaker: self.parameters_of(speaker) for speaker in self.speakers},
            "summary": {row.name: vars(row) for row in self.summary},
            "provenance": self.provenance,
            "draws": self.dataset.to_dict(),
        }
        with written_whole(path) as temporary:
            temporary.write_text(json.dumps(payload, indent=1, allow_nan=False) + "\n", "utf-8")

    @classmethod
    def load(cls, path: str | Path) -> ParameterDraws:
        """Read what `save` wrote.

        Raises
        ------
        InputError
            When the file cannot be read or holds no draws.
        """
        import xarray

        text = read_text(path, "Draws")
        try:
            payload = parse_json(text)
            dataset = xarray.Dataset.from_dict(payload["draws"])
            found = cls(str(payload["model"]), dataset, dict(payload["provenance"]))
            found._check()
        except Exception as error:  # xarray raises nearly anything on damaged tables
            raise InputError(
                f"'{path}' holds no draws of parameters; expected a JSON file that "
                "ParameterDraws.save wrote"
            ) from error
        return found

    def _check(self) -> None:
        """Raise `ValueError` unless every variable holds finite draws by chain."""
        for name, array in self.dataset.data_vars.items():
            if not {"chain", "draw"} <= set(array.dims) or not np.isfinite(array.values).all():
                raise ValueError(f"{name} holds no finite draws")
        if not all(map(np.isfinite, (v for s in self.parameters.values() for v in s.values()))):
            raise ValueError("the medians are not finite")

    def _medians(self, chosen: Mapping[str, str]) -> dict[str, dict[str, float]]:
        medians: dict[str, dict[str, float]] = {}
        for name, array in self.dataset.data_vars.items():
            section = array.attrs.get("section")
            if section is None:
                continue
            own = f"{name}{_BY_SPEAKER}"
            of = self.dataset[own].sel(chosen) if chosen and own in self.dataset else array
            median = of.median(("chain", "draw"))
            if section == "weights":
                shares = (median / median.sum()).values
                parts = map(str, array.component.values)
                medians["weights"] = dict(zip(parts, map(float, shares), strict=True))
            else:
                medians.setdefault(section, {})[str(name)] = float(median)
        return medians


def _summed(name: str, draws: xarray.DataArray) -> ParameterSummary:
    table = torch.from_numpy(np.ascontiguousarray(draws.transpose("chain", "draw").values))
    low, median, high = np.quantile(table.numpy(), [0.025, 0.5, 0.975])
    r_hat = split_gelman_rubin(table, chain_dim=0, sample_dim=1)
    ess = effective_sample_size(table, chain_dim=0, sample_dim=1)
    return ParameterSummary(name, float(median), float(low), float(high), float(r_hat), float(ess))

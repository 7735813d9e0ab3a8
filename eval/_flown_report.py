"""What flown searches found beside those on the grid, as a table with intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import binomtest

from sloop_ppl.eval._flown_trial import ARMS, FlownTrial

__all__ = ["ArmSummary", "flown_lines", "flown_summary"]


@dataclass(frozen=True)
class ArmSummary:
    """What came of one arm.

    Parameters
    ----------
    arm
        Its name.
    n
        Trials whose target can be reached under it.
    out_of_reach
        Trials that are left out because no pose that can be reached has the target in view.
    success, success_ci95
        Share that was found, and its Wilson interval.
    against_grid
        Success divided by that on the grid at the same altitude, over the same trials.
    steps, discounted_reward
        Means.
    detection_rate
        Detections of looks with the target in view.
    false_rate
        Reports of looks without it.
    wrong_finds
        Finds that marked nothing, per trial.
    collisions, moves
        Collisions, and moves forward that were flown.
    collisions_ci95
        Interval of the collisions per move (exact, Clopper and Pearson).
    lost
        Trials that ended with the drone lost.
    time_s
        Mean simulated time.
    """

    arm: str
    n: int
    out_of_reach: int
    success: float
    success_ci95: tuple[float, float]
    against_grid: float | None
    steps: float
    discounted_reward: float
    detection_rate: float
    false_rate: float
    wrong_finds: float
    collisions: int
    moves: int
    collisions_ci95: tuple[float, float]
    lost: int
    time_s: float

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in vars(self).items()
        }


def flown_summary(trials: Sequence[FlownTrial]) -> list[ArmSummary]:
    """Return what came of each arm, over the trials of which all arms are done.

    Parameters
    ----------
    trials
        Those of `fly_trials`; a stopped run may lack arms of some, which are left out.
    """
    names = [a.name for a in ARMS if any(t.arm == a.name for t in trials)]
    altitude = {a.name: a.altitude_m for a in ARMS}
    by_case: dict[tuple[str, str, int], dict[str, FlownTrial]] = {}
    for trial in trials:
        by_case.setdefault(trial.key[:3], {})[trial.arm] = trial
    whole = [case for case in by_case.values() if len(case) == len(names)]
    summaries = []
    for name in names:
        cases = [case for case in whole if case[name].reachable]
        grid = next(
            (n for n in names if n.startswith("grid") and altitude[n] == altitude[name]), ""
        )
        of_arm = [case[name] for case in cases]
        of_grid = [case[grid] for case in cases] if grid else []
        summaries.append(_summary(name, of_arm, of_grid, len(whole) - len(cases)))
    return summaries


def flown_lines(summaries: Sequence[ArmSummary]) -> list[str]:
    """Return the summaries as a Markdown table."""
    names = (
        "arm", "n", "success", "of grid", "steps", "reward", "detected", "false", "wrong finds",
        "collisions / moves", "time, s",
    )  # fmt: skip
    lines = [
        f"| {' | '.join(names)} |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for s in summaries:
        low, high = s.success_ci95
        ratio = "" if s.against_grid is None else f"{s.against_grid:.2f}"
        hits = f"{s.collisions} / {s.moves} (≤ {s.collisions_ci95[1]:.4f})" if s.time_s else "–"
        lines.append(
            f"| {s.arm} | {s.n} | {s.success:.3f} [{low:.3f}, {high:.3f}] | {ratio} | "
            f"{s.steps:.1f} | {s.discounted_reward:.0f} | {s.detection_rate:.2f} | "
            f"{s.false_rate:.4f} | {s.wrong_finds:.2f} | {hits} | {s.time_s:.0f} |"
        )
    return lines


def _summary(
    name: str, trials: Sequence[FlownTrial], grid: Sequence[FlownTrial], left_out: int
) -> ArmSummary:
    n = len(trials)
    found = sum(t.found for t in trials)
    of_grid = sum(t.found for t in grid)
    seen, looks = sum(t.in_view for t in trials), sum(t.looks for t in trials)
    hits, moves = sum(t.collisions for t in trials), sum(t.moves for t in trials)
    return ArmSummary(
        arm=name, n=n, out_of_reach=left_out, success=found / max(n, 1),
        success_ci95=_wilson(found, n),
        against_grid=None if name.startswith("grid") or not of_grid else found / of_grid,
        steps=_mean([t.steps for t in trials]),
        discounted_reward=_mean([t.discounted_reward for t in trials]),
        detection_rate=sum(t.detected for t in trials) / max(seen, 1),
        false_rate=sum(t.false_reports for t in trials) / max(looks - seen, 1),
        wrong_finds=_mean([t.wrong_finds for t in trials]),
        collisions=hits, moves=moves, collisions_ci95=_exact(hits, moves),
        lost=sum(t.lost for t in trials), time_s=_mean([t.time_s for t in trials]),
    )  # fmt: skip


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else 0.0


def _wilson(k: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson 1927)."""
    if n == 0:
        return 0.0, 1.0
    low, high = binomtest(k, n).proportion_ci(method="wilson")
    return float(low), float(high)


def _exact(k: int, n: int) -> tuple[float, float]:
    """Return the exact 95 % interval of a rate; one-sided where there was none (Clopper 1934)."""
    if n == 0:
        return 0.0, 1.0
    low, high = binomtest(k, n, alternative="two-sided" if k else "less").proportion_ci()
    return float(low), float(high)

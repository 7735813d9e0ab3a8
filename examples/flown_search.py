"""Draw the paper's last figure anew: the belief of a search on the left, its flight on the right.

Run ``python examples/flown_search.py out.png``; it needs ``pip install 'sloop-ppl[sim]'`` and
graphics (EGL or OSMesa). ``SMOKE_TEST=1`` flies two steps and draws small.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import sloop_ppl as sloop
from sloop_ppl.planning import SearchConfig, run_search
from sloop_ppl.plots import plot_search
from sloop_ppl.simulation import (
    Camera,
    Drone,
    MujocoEnvironment,
    World,
    camera_panel,
    flight_plan,
)

TEXT = (
    "The red car is on West 6th Street in front of Liberty Textiles Building and the green car is "
    "east of Liberty Textiles Building."
)
PLACES = {"RedHonda": (-1.0, -18.0), "GreenToyota": (40.0, -2.0)}


def main(path: Path, *, smoke: bool = False) -> None:
    """Infer, fly and draw."""
    posterior = sloop.infer(TEXT, "cleveland")
    world = World.from_map(posterior.city, {t: PLACES[t] for t in posterior.targets})
    posterior = replace(posterior, city=world.city)
    config = SearchConfig(sims=50 if smoke else 1000, max_steps=2 if smoke else 80)
    config, sensor = flight_plan(world.city, config, 14.0, "camera")
    rng = np.random.default_rng(0)
    drone = Drone(world, (-27.5, 22.5, 0.0), altitude_m=14.0, wind_m_s=2.0, rng=rng)
    beliefs = {t: posterior.belief(t) for t in posterior.targets}
    with Camera(world, drone) as camera:
        flight = MujocoEnvironment(world, drone, camera, config=config, sensor=sensor)
        seen = {}

        def keep(_step: object) -> None:
            if flight.log.detections[-1]:
                seen["last"] = camera_panel(camera.picture(), world, flight.log.detections[-1])

        episode = run_search(
            beliefs, world.city, world.places, environment=flight, config=config,
            sensor=sensor, rng=rng, on_step=keep,
        )  # fmt: skip
        size = (160, 120) if smoke else (1000, 750)
        chase = camera.chase(*size, distance_m=22.0)
        figure = Figure(figsize=(13.0, 6.4), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.1))
        plot_search(episode, world.city, ax=left, beliefs=beliefs)
        right.imshow(chase)
        right.set_axis_off()
        state = "found" if episode.found else "searched"
        right.set_title(f"{drone.time_s:.0f} s of flight at 14 m: {state}", fontsize=11)
        if "last" in seen:
            inset = right.inset_axes((0.66, 0.02, 0.32, 0.32))
            inset.imshow(seen["last"])
            inset.set(xticks=[], yticks=[])
        figure.savefig(path, dpi=110, bbox_inches="tight")
    print(f"{path}: {episode.steps} steps, found {', '.join(episode.found_targets) or 'nothing'}")


if __name__ == "__main__":
    main(
        Path(sys.argv[1] if len(sys.argv) > 1 else "flown_search.png"),
        smoke=bool(os.environ.get("SMOKE_TEST")),
    )

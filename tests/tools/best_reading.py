"""`bayes` on the most probable reading and the most probable places alone, for `--models`."""

from __future__ import annotations

from dataclasses import replace

from sloop_ppl.models import preset

BEST_READING = replace(preset("bayes"), sum_readings=False, sum_grounds=False)

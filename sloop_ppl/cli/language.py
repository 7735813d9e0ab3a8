"""`sloop parse`."""

from __future__ import annotations

from sloop_ppl.cli.options import Json, Map, Targets, Text
from sloop_ppl.cli.output import print_data, print_json

__all__ = ["parse"]


def parse(text: Text, map_: Map, targets: Targets = None, json: Json = False) -> None:
    """Read spatial relations from a sentence."""
    import sloop_ppl as sloop
    from sloop_ppl.bridge.report import relation_table
    from sloop_ppl.language import load_targets, no_relation_found

    city = sloop.load_map(map_)
    declared = load_targets(targets) if targets else None
    said = sloop.parse(text, city, targets=declared)
    if json:
        print_json(said.to_json())
    elif said.relations:
        print_data(relation_table(said))
    if not said.relations:
        raise no_relation_found(said, city, declared)

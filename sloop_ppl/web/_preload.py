"""What the process that workers are forked from loads before the first of them.

It is imported there and nowhere else: to import it is to load the planners' machine code.
"""

from __future__ import annotations

from sloop_ppl.bridge import searching
from sloop_ppl.language import parse
from sloop_ppl.maps import load_map, osm
from sloop_ppl.planning import warm_up

__all__: list[str] = []

_LOADED = (searching, osm)
parse("the green toyota is near ivy", load_map("cleveland"))
warm_up()

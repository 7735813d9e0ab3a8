"""The widget's class, apart because it needs anywidget."""

from __future__ import annotations

from typing import Any

import anywidget
import traitlets

from sloop_ppl.web._stylesheet import static_text, view_sheet

__all__ = ["SloopWidget"]


class SloopWidget(anywidget.AnyWidget):
    """A map with a belief or a search.

    Parameters
    ----------
    payload
        What is shown, see `sloop_ppl.web.page_file.shown_payload`.
    """

    _esm = static_text("view.js")
    _css = view_sheet()
    payload = traitlets.Dict().tag(sync=True)
    picked = traitlets.Dict(allow_none=True, default_value=None).tag(sync=True)
    area: Any = traitlets.List(allow_none=True, default_value=None).tag(sync=True)
    answer = traitlets.Dict(allow_none=True, default_value=None).tag(sync=True)

    def __init__(self, payload: dict[str, Any]) -> None:
        super().__init__(payload=payload)

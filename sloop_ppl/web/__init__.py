"""The workbench in the browser, its pages for annotators and speakers, and the notebook widget.

Names load on first use; the server needs ``sloop-ppl[web]``, the widget ``sloop-ppl[notebook]``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sloop_ppl._rooms import load_later

if TYPE_CHECKING:
    from sloop_ppl.web.application import WebSettings
    from sloop_ppl.web.notebook import widget
    from sloop_ppl.web.page_file import write_page
    from sloop_ppl.web.server import serve
    from sloop_ppl.web.study import Study, export_answers, prepare_study

__all__ = [
    "Study",
    "WebSettings",
    "export_answers",
    "prepare_study",
    "serve",
    "widget",
    "write_page",
]

_HOMES = {
    "application": ("WebSettings",),
    "notebook": ("widget",),
    "page_file": ("write_page",),
    "server": ("serve",),
    "study": ("Study", "export_answers", "prepare_study"),
}
__getattr__ = load_later(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)

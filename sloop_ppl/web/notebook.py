"""The view in a notebook: an anywidget of a posterior or a search."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sloop_ppl.errors import InputError
from sloop_ppl.web._posteriors import questions_payload
from sloop_ppl.web.page_file import shown_payload

if TYPE_CHECKING:
    from sloop_ppl.inference import Posterior
    from sloop_ppl.planning import Episode

__all__ = ["widget"]


def widget(shown: Posterior | Episode) -> Any:
    """Return a widget that shows a posterior or plays a search, and sends back what is drawn.

    Parameters
    ----------
    shown
        A posterior, or an episode of ``sloop_ppl.search(..., keep_beliefs=True)``.

    Returns
    -------
    anywidget.AnyWidget
        Its traits ``picked`` (``{"at": [x, y], "target": ID, "is_there": bool}``, metres), ``area``
        (west, south, east, north, or the corners of a polygon) and ``answer`` (``{"question",
        "answer"}``) change when someone draws evidence or an area, or answers a question;
        ``observe`` them.

    Raises
    ------
    InputError
        When anywidget is not installed, `shown` is neither, or an episode has kept no beliefs.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> post = sloop.infer("the red bike is near Ivy", "cleveland")
    >>> sloop.widget(post).area is None
    True
    """
    try:
        from sloop_ppl.web._notebook_widget import SloopWidget
    except ModuleNotFoundError as error:
        raise InputError(
            f"The widget needs {error.name}, which is not installed; run pip install "
            "'sloop-ppl[notebook]'"
        ) from error
    from sloop_ppl.inference import Posterior
    from sloop_ppl.planning import Episode

    if isinstance(shown, Posterior):
        payload = shown_payload(shown)
        payload["questions"] = questions_payload(shown)
    elif isinstance(shown, Episode):
        posterior = getattr(shown, "posterior", None)
        if posterior is None:
            raise InputError("This episode keeps no posterior; search with sloop_ppl.search")
        payload = shown_payload(posterior, shown)
    else:
        raise InputError(
            f"A {type(shown).__name__} is to be shown; expected a posterior or an episode"
        )
    return SloopWidget(payload)

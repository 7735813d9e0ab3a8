"""The workbench page as tests drive it: its state, places on its map, what is drawn."""

from __future__ import annotations

import base64
import io
import json
from urllib.parse import quote, unquote

import numpy as np
from PIL import Image

from sloop_ppl.plots._palette import belief_colours


def state_of(page):
    """Return the state in the address."""
    return json.loads(unquote(page.url.partition("#")[2]))


def address(**state):
    return f"/#{quote(json.dumps(state))}"


def on_screen(page, x_m, y_m, frame="#map-a"):
    """Return where a place is on the screen."""
    return page.evaluate(
        """([frame, x, y]) => {
            const root = document.querySelector(`${frame} svg.map`);
            const at = new DOMPoint(x, -y).matrixTransform(root.getScreenCTM());
            return [at.x, at.y];
        }""",
        [frame, x_m, y_m],
    )


def click_at(page, x_m, y_m):
    page.mouse.click(*on_screen(page, x_m, y_m))


def drawn_belief(page, frame="#map-a"):
    """Return the picture of the belief, RGBA, row 0 in the south."""
    href = page.locator(f"{frame} .belief image").get_attribute("href")
    picture = Image.open(io.BytesIO(base64.b64decode(href.partition(",")[2])))
    return np.asarray(picture.convert("RGBA"))[::-1]


def colours_of(belief):
    """Return the colours that a belief is drawn in, RGBA of 0 to 255, row 0 in the south."""
    shares = (belief / belief.max()).astype(np.float16).astype(float)
    table = (255 * np.asarray(belief_colours()(np.linspace(0, 1, 256)))).round()
    return table[np.floor(shares * 255 + 0.5).astype(int)]


def settle(page):
    """Wait until what was asked for last has been answered."""
    page.locator("#maps[aria-busy=false]").wait_for(state="attached")


def type_text(page, text):
    page.fill("#text", text)
    settle(page)

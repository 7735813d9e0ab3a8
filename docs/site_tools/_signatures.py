"""Signatures broken into lines without a process for each, as mkdocstrings would start."""

from __future__ import annotations

from mkdocstrings_handlers.python._internal import rendering

__all__ = ["break_signature", "use_own_formatter"]

OPENING, CLOSING = "([{", ")]}"


def use_own_formatter() -> None:
    """Let mkdocstrings break signatures by `break_signature`.

    Notes
    -----
    Ruff, which it would run for each of a thousand signatures, took minutes for one of them. Where
    a later version of mkdocstrings has no such function, it goes on as it wants to.
    """
    if hasattr(rendering, "_get_formatter"):
        rendering._get_formatter = lambda: break_signature  # no public way to choose one


def break_signature(code: str, line_length: int) -> str:
    """Return ``def name(...): pass`` with a line per parameter where it is longer than a line.

    Parameters
    ----------
    code
        The signature, in one line.
    line_length
        Characters that a line may have.
    """
    if len(code) <= line_length or not code.startswith("def "):
        return code
    start, parts, depth, quote = code.find("(") + 1, [""], 1, ""
    for end in range(start, len(code)):
        sign = code[end]
        if quote:
            quote = "" if sign == quote else quote
        elif sign in "'\"":
            quote = sign
        elif sign in OPENING:
            depth += 1
        elif sign in CLOSING:
            depth -= 1
            if depth == 0:
                break
        if sign == "," and depth == 1 and not quote:
            parts.append("")
        else:
            parts[-1] += sign
    else:
        return code
    lines = "".join(f"    {part.strip()},\n" for part in parts if part.strip())
    return f"{code[:start]}\n{lines}{code[end:]}"

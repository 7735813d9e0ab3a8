"""Turn the id of a declared object into what people call it."""

from __future__ import annotations

import re

from sloop_ppl.language import TargetObject

__all__ = ["declared_object"]

_COLOURS = frozenset(
    {
        "black", "blue", "brown", "gold", "gray", "green", "grey", "orange", "pink", "purple",
        "red", "silver", "white", "yellow",
    }
)  # fmt: skip
_CAR_MAKES = frozenset(
    {
        "audi", "bmw", "chevrolet", "chevy", "fiat", "ford", "honda", "hyundai", "jeep", "kia",
        "mazda", "nissan", "subaru", "tesla", "toyota", "volkswagen", "volvo", "vw",
    }
)  # fmt: skip
_SYNONYMS = {"bike": ("bicycle",), "bicycle": ("bike",), "car": ("vehicle", "automobile")}


def declared_object(object_id: str) -> TargetObject:
    """Return the object an evaluation line declares by its CamelCase id.

    Parameters
    ----------
    object_id
        CamelCase words: optionally a colour, then a noun or the make of a car.

    Returns
    -------
    TargetObject
        With `colour` and `kind` set, and as `names` the ways to call it, the fullest first. A
        make of car is only a name: the kind is ``"car"``, so that colour decides over brand.

    Examples
    --------
    >>> declared_object("GreenToyota").names[:4]
    ('green toyota', 'toyota', 'green car', 'green vehicle')
    >>> declared_object("MyDog")
    TargetObject(id='MyDog', names=('my dog', 'dog'), colour=None, kind='dog')
    """
    words = [w.lower() for w in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", object_id)]
    words = words or [object_id.lower()]
    colour = words[0] if words[0] in _COLOURS and len(words) > 1 else None
    noun = next((w for w in reversed(words) if w.isalpha()), words[-1])
    kind = "car" if noun in _CAR_MAKES else noun
    nouns = (noun, kind, *_SYNONYMS.get(kind, ()))
    names = [" ".join(words), noun, *(f"{colour} {n}" if colour else n for n in nouns)]
    if kind != "car":  # there is often more than one car, so its colour has to be said
        names += nouns
    return TargetObject(object_id, tuple(dict.fromkeys(names)), colour, kind)

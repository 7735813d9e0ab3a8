"""Names say what a value is: no told, said or heard in the code of the package."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("sloop_ppl", "models", "inference", "eval")
VAGUE = frozenset(("told", "said", "heard", "telling", "tells", "hear", "hears", "saying"))
ALLOWED = {
    # `sloop.search(..., said={step: text})` is a name that the contracts fix.
    ("sloop_ppl/bridge/searching.py", "said"),
    # Its callers hand that argument on.
    ("sloop_ppl/bridge/_search_request.py", "said"),
    ("sloop_ppl/web/_search_worker.py", "said"),
}


def sources():
    """Return the modules of the package, each once: a room may be linked into the package."""
    return sorted({path.resolve() for room in ROOMS for path in (ROOT / room).rglob("*.py")})


def names(tree):
    """Yield the identifiers of a module, with their lines."""
    for node in ast.walk(tree):
        for field in ("id", "arg", "attr", "name", "asname", "rest"):
            value = getattr(node, field, None)
            if isinstance(value, str):
                yield value, getattr(node, "lineno", 0)
        if isinstance(node, ast.Global | ast.Nonlocal):
            yield from ((value, node.lineno) for value in node.names)


def vague(identifier):
    """Return whether one of the words of an identifier is vague; CamelCase has words too."""
    parted = "".join(f"_{c.lower()}" if c.isupper() else c for c in identifier)
    return any(word in VAGUE for word in parted.replace(".", "_").split("_"))


@pytest.mark.parametrize(
    ("identifier", "expected"),
    [
        ("told", True), ("_told", True), ("ToldScene", True), ("said_distance_m", True),
        ("_having_heard", True), ("sloop_ppl.bridge.told", True), ("untold", False),
        ("stated_distance_m", False), ("utterances", False), ("hearer", False),
    ],
)  # fmt: skip
def test_which_names_are_vague(identifier, expected):
    assert vague(identifier) is expected


def test_names_say_what_a_value_is():
    found, used = [], set()
    for path in sources():
        file = path.relative_to(ROOT).as_posix()
        if vague(path.stem):
            found.append(f"{file}: the module's name")
        for name, line in names(ast.parse(path.read_text(encoding="utf-8"))):
            if (file, name) in ALLOWED:
                used.add((file, name))
            elif vague(name):
                found.append(f"{file}:{line}: {name}")
    assert found == [], "name the value: payload, record, lines, utterance, log_likelihood, ..."
    assert used == ALLOWED, "the list of exceptions holds some that are no longer there"

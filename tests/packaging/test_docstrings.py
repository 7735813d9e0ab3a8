"""numpydoc parses every public docstring: names alone, prose below them, types in signatures."""

import ast
import re

import pytest
from numpydoc.docscrape import NumpyDocString
from support.tree import ROOT, ROOTS

DEFINED = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
NAMED = ("Parameters", "Other Parameters", "Attributes")
ERRORS = ("Raises", "Warns")


def modules():
    """Return the path of each module of ours -> its syntax tree."""
    paths = [path for folder in ROOTS.values() for path in folder.rglob("*.py")]
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(paths)}


def exported(tree):
    """Return the names in ``__all__``; those of a private module are public in its package."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return set()


def public(tree):
    """Yield the module, then each class, function, method and property that is public."""
    yield tree
    names = exported(tree)
    tops = [node for node in ast.walk(tree) if isinstance(node, DEFINED) and node in tree.body]
    for top in (node for node in tops if node.name in names):
        yield top
        if isinstance(top, ast.ClassDef):
            for node in top.body:
                if isinstance(node, DEFINED) and not node.name.startswith("_"):
                    yield node


def arguments(node):
    """Return the parameters of a function as they are documented, or None for a property."""
    if any(ast.unparse(mark).endswith(("property", ".setter")) for mark in node.decorator_list):
        return None
    spec = node.args
    names = [arg.arg for arg in (*spec.posonlyargs, *spec.args, *spec.kwonlyargs)]
    names += [f"*{spec.vararg.arg}"] if spec.vararg else []
    names += [f"**{spec.kwarg.arg}"] if spec.kwarg else []
    return {name for name in names if name not in ("self", "cls")}


def fields(node, classes):
    """Return what a class is made with: its own ``__init__``, else its fields and its bases'."""
    for part in node.body:
        if isinstance(part, ast.FunctionDef) and part.name in ("__init__", "__new__"):
            return arguments(part)
    names = {part.target.id for part in node.body if isinstance(part, ast.AnnAssign)}
    for base in node.bases:
        name = ast.unparse(base).split("[")[0].split(".")[-1]
        names |= fields(classes[name], classes) if name in classes else set()
    return names


def faults(doc, expected):
    """Yield the entry at fault and what is wrong with it, for each fault of a docstring."""
    parsed = NumpyDocString(doc)
    for section in NAMED:
        for name, kind, text in parsed[section]:
            if kind:
                yield name, f"{section}: {kind!r} stands where the type does, put it below the name"
            if not any(text):
                yield name, f"{section}: no description below the name"
    for section in ERRORS:
        for name, kind, text in parsed[section]:
            if name or not all(re.fullmatch(r"[A-Za-z_.]+", error) for error in kind.split(", ")):
                yield name or kind, f"{section}: put when below the name of the error"
            if not any(text):
                yield name or kind, f"{section}: no description below the name"
    for section in ("Returns", "Yields"):
        for name, kind, text in parsed[section]:
            if name or re.search(r"[.:;]$| (the|an?|when|where|which|for|is|are) ", kind):
                yield name or kind, f"{section}: {kind!r} is no type"
            if not any(text):
                yield kind, f"{section}: no description below the type"
    for name in [one for entry in parsed["Parameters"] for one in entry[0].split(", ")]:
        if expected is not None and name not in expected:
            yield name, "Parameters: the signature has no such name"


def line_of(lines, node, name):
    """Return the line in which an entry of a node's docstring begins."""
    own = node.body[0]
    for number in range(own.lineno, own.end_lineno + 1):
        if re.match(rf"\s*([\w*]+, )*{re.escape(name)}(,| :|\s*$)", lines[number - 1]):
            return number
    return own.lineno


def test_every_public_docstring_parses():
    trees = modules()
    classes = {
        n.name: n for tree in trees.values() for n in tree.body if isinstance(n, ast.ClassDef)
    }
    found, parsed = [], 0
    for path, tree in trees.items():
        lines = path.read_text(encoding="utf-8").splitlines()
        for node in public(tree):
            doc = ast.get_docstring(node)
            if doc is None:
                continue
            expected = None
            if isinstance(node, ast.ClassDef):
                expected = fields(node, classes)
            elif not isinstance(node, ast.Module):
                expected = arguments(node)
            parsed += 1
            for name, fault in faults(doc, expected):
                place = f"{path.relative_to(ROOT)}:{line_of(lines, node, name)}"
                found.append(f"{place}: {getattr(node, 'name', 'module')}, {name}: {fault}")
    assert parsed > 1000
    assert not found, "\n".join(["", *found])


GOOD = """Turn.

Parameters
----------
a, b
    Both of them.
*names
    Others.

Returns
-------
tuple of str
    What is left.

Raises
------
InputError
    When there is none.
"""


@pytest.mark.parametrize(
    ("old", "new", "at_fault", "message"),
    [
        ("a, b\n    Both", "a, b : both", "a, b", "'both of them.' stands where the type does"),
        ("a, b\n    Both of them.", "a, b", "a, b", "no description below the name"),
        ("*names", "names", "names", "the signature has no such name"),
        ("InputError\n    When", "InputError : when", "InputError", "put when below the name"),
        ("tuple of str", "the words that are left.", "the words that are left.", "is no type"),
    ],
)
def test_faults_are_found(old, new, at_fault, message):
    expected = {"a", "b", "*names"}
    assert list(faults(GOOD, expected)) == []
    found = list(faults(GOOD.replace(old, new), expected))
    assert {name for name, _ in found} == {at_fault}
    assert message in found[0][1]

"""The examples in docstrings run; pytest's own collector would import the bare folders."""

import doctest
import importlib

import pytest
from support.tree import module_names

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.mark.parametrize("name", [n for n in module_names() if not n.endswith("__main__")])
def test_examples_in_docstrings_run(name):
    said = []
    module = importlib.import_module(name)
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    for test in doctest.DocTestFinder().find(module, module.__name__):
        runner.run(test, out=said.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(said)

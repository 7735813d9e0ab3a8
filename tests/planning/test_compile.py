from __future__ import annotations

import types

from sloop_ppl.planning.compile import jit


def double(number):
    return 2 * number


def test_without_a_place_for_a_cache_machine_code_is_made_anew():
    nowhere = types.FunctionType(double.__code__.replace(co_filename="<nowhere>"), {}, "double")
    compiled = jit(nowhere)
    assert compiled(21) == 42
    assert compiled.stats.cache_path is None
    assert jit(double).stats.cache_path is not None

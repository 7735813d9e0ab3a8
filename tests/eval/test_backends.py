"""Ray and Dask, each on a cluster of this machine, do what joblib does."""

import sys

import pytest
from support.small_sweeps import request, table_of

from sloop_ppl.errors import InputError
from sloop_ppl.eval._backends import BACKENDS
from sloop_ppl.eval._sweep_files import sweep_files

QUIET = [
    "ignore::ResourceWarning",
    "ignore::DeprecationWarning",
    "ignore::FutureWarning",
    "ignore::pytest.PytestUnraisableExceptionWarning",
]  # what the clusters' own code warns of is not ours


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["ray", "dask"])
@pytest.mark.filterwarnings(*QUIET)
def test_a_local_cluster_gives_the_same_table(tmp_path, backend):
    pytest.importorskip("ray" if backend == "ray" else "distributed")
    cluster = sweep_files(request(tmp_path, backend=backend, out=tmp_path / "cluster"))
    assert table_of(cluster) == table_of(sweep_files(request(tmp_path)))
    (part,) = cluster.parts.glob("*.jsonl")  # one worker was asked for
    assert part.stat().st_size > 0


@pytest.mark.parametrize(("backend", "package"), [("ray", "ray"), ("dask", "distributed")])
def test_a_missing_package_is_told_before_any_work(tmp_path, monkeypatch, backend, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=rf'pip install "sloop-ppl\[{backend}\]"'):
        list(BACKENDS[backend](len, [[1]], workers=1, address=None))
    with pytest.raises(InputError, match=rf'pip install "sloop-ppl\[{backend}\]"'):
        sweep_files(request(tmp_path, backend=backend))
    assert not request(tmp_path).out.exists()


def test_an_address_at_which_nobody_answers():
    with pytest.raises(InputError, match=r"No Dask cluster can be used at 'tcp://127.0.0.1:1': "):
        list(BACKENDS["dask"](len, [[1]], workers=1, address="tcp://127.0.0.1:1"))


def test_joblib_in_this_process():
    assert list(BACKENDS["joblib"](len, [[1], [1, 2]], workers=1, address=None)) == [1, 2]

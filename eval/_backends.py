"""Where the jobs of a sweep run: processes of this machine, a Ray cluster, a Dask cluster.

Ray and Dask are called directly, not as backends of joblib: joblib's Ray backend yields no result
before all are done (it refuses ``return_as="generator_unordered"``), which would end the progress
bar and the stop at the first fault, and its Dask backend waits for ever when a worker is killed,
which is reported here as `WorkersLost` and tried again (joblib 1.6, Ray 2.60, Dask 2026.8).
"""

from __future__ import annotations

import logging
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from importlib import import_module
from itertools import islice
from typing import Any, Protocol, TypeVar
from warnings import catch_warnings, simplefilter

from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.eval._driver_watch import Driver, end_with
from sloop_ppl.registry import Registry

__all__ = ["BACKENDS", "Backend", "WorkersLost", "check_backend"]

Job = TypeVar("Job")
Done = TypeVar("Done")

_PACKAGES = {"ray": "ray", "dask": "distributed"}

_THREADS = {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


class WorkersLost(SloopError):
    """Workers ended while they worked; the jobs that were not done can be asked for again."""


class Backend(Protocol):
    """Do jobs in some workers, one thread each."""

    def __call__(
        self,
        work: Callable[[Job], Done],
        jobs: Sequence[Job],
        *,
        workers: int,
        address: str | None,
    ) -> Iterator[Done]:
        """Yield what `work` returns for each job, in the order in which they are done.

        Raises
        ------
        InputError
            When the cluster cannot be reached, or the backend takes no address.
        WorkersLost
            When a worker was killed.
        """
        ...


def check_backend(name: str, address: str | None) -> None:
    """Check what can be known of a backend before any work.

    Raises
    ------
    UnknownName
        When there is none of this name.
    InputError
        When it takes no address and one is given, or needs a package that is not there.
    """
    BACKENDS[name]
    if name in _PACKAGES:
        _package(name)
    if name == "joblib" and address is not None:
        raise InputError(
            f"Backend joblib runs on this machine and takes no address ('{address}' was given); "
            "leave --address out, or choose ray or dask"
        )


def _joblib(
    work: Callable[[Job], Done], jobs: Sequence[Job], *, workers: int, address: str | None
) -> Iterator[Done]:
    """Run the jobs in processes of this machine; with one worker in this process itself."""
    check_backend("joblib", address)
    if workers == 1:
        yield from map(work, jobs)
        return
    from joblib import Parallel, delayed, parallel_config
    from joblib.externals.loky import get_reusable_executor
    from joblib.externals.loky.process_executor import BrokenProcessPool

    with parallel_config(
        backend="loky",
        inner_max_num_threads=1,
        initializer=end_with,
        initargs=(Driver.this(), True),
    ):
        pool = Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1)
        results = pool(delayed(work)(job) for job in jobs)
    try:
        for result in results:  # noqa: UP028 - they are closed below, not by the consumer
            yield result
    except BrokenProcessPool as error:
        raise WorkersLost(f"A worker was killed ({type(error).__name__})") from error
    except BaseException:
        with catch_warnings():
            simplefilter("ignore", UserWarning)  # that jobs were cancelled, which was meant
            results.close()
        get_reusable_executor().shutdown(wait=False, kill_workers=True)
        raise


def _ray(
    work: Callable[[Job], Done], jobs: Sequence[Job], *, workers: int, address: str | None
) -> Iterator[Done]:
    """Run the jobs on a Ray cluster: one of this machine, or that at `address`."""
    ray = _package("ray")
    _knock("Ray", address)
    ours = not ray.is_initialized()
    if ours:
        local: dict[str, Any] = {"num_cpus": workers, "include_dashboard": False}
        try:
            ray.init(
                address=address,
                configure_logging=False,
                log_to_driver=False,
                runtime_env={"env_vars": _THREADS},
                **(local if address is None else {}),
            )
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise _unreachable("Ray", address, error) from error
    try:
        task = ray.remote(num_cpus=1, max_retries=0)(lambda job: work(job))
        waiting = iter(jobs)
        running = [task.remote(job) for job in islice(waiting, max(100, 2 * workers))]
        while running:
            done, running = ray.wait(running, num_returns=1)
            try:
                result = ray.get(done[0])
            except (ray.exceptions.WorkerCrashedError, ray.exceptions.NodeDiedError) as error:
                raise WorkersLost(f"A worker was killed ({type(error).__name__})") from error
            running += [task.remote(job) for job in islice(waiting, 1)]
            yield result
    finally:
        if ours:
            ray.shutdown()


def _dask(
    work: Callable[[Job], Done], jobs: Sequence[Job], *, workers: int, address: str | None
) -> Iterator[Done]:
    """Run the jobs on a Dask cluster: one of this machine, or that at `address`."""
    distributed = _package("dask")
    _knock("Dask", address)
    with ExitStack() as open_:
        try:
            cluster = address
            if address is None:
                cluster = open_.enter_context(
                    distributed.LocalCluster(
                        n_workers=workers,
                        threads_per_worker=1,
                        dashboard_address=None,
                        silence_logs=logging.CRITICAL,
                    )
                )
            client = open_.enter_context(distributed.Client(cluster))
        except (OSError, ValueError) as error:
            raise _unreachable("Dask", address, error) from error
        futures = client.map(work, list(jobs), pure=False)
        try:
            for future in distributed.as_completed(futures):
                yield future.result()
        except distributed.KilledWorker as error:
            raise WorkersLost(f"A worker was killed ({type(error).__name__})") from error
        finally:
            client.cancel(futures)


def _package(backend: str) -> Any:
    name = _PACKAGES[backend]
    try:
        return import_module(name)
    except ImportError as error:
        raise InputError(
            f"Backend {backend} needs the package {name}, which is not installed; "
            f'pip install "sloop-ppl[{backend}]"'
        ) from error


def _knock(cluster: str, address: str | None) -> None:
    """Refuse an address at which nobody answers; the clusters themselves would try for minutes."""
    host, _, port = (address or "").rpartition("://")[2].rpartition(":")
    if not (host and port.isdigit()):
        return
    try:
        socket.create_connection((host, int(port)), timeout=10).close()
    except (OSError, OverflowError) as error:
        raise _unreachable(cluster, address, error) from error


def _unreachable(cluster: str, address: str | None, error: Exception) -> InputError:
    where = "on this machine" if address is None else f"at '{address}'"
    message = " ".join(str(error).split())[:200]
    return InputError(f"No {cluster} cluster can be used {where}: {message}; check --address")


BACKENDS: Registry[Backend] = Registry("backend")
"""Backends by name; each is called with the work, the jobs, `workers` and `address`."""

BACKENDS.add("joblib", _joblib)
BACKENDS.add("ray", _ray)
BACKENDS.add("dask", _dask)

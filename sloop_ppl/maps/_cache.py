"""Keep what is expensive to compute, by content, within a budget of memory."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import RLock
from typing import Any, TypeVar

__all__ = ["BoundedCache"]

T = TypeVar("T")


class BoundedCache:
    """A cache that forgets what was used longest ago when its budget is spent.

    Parameters
    ----------
    budget_bytes
        What the entries may cost together; one entry may cost more on its own.

    Examples
    --------
    >>> cache = BoundedCache(budget_bytes=100)
    >>> cache.get("a", lambda: 1, cost_bytes=60), cache.get("a", lambda: 2, cost_bytes=60)
    (1, 1)
    >>> cache.get("b", lambda: 3, cost_bytes=60), len(cache)
    (3, 1)
    """

    # By hand, not cachetools.LRUCache: that refuses an entry larger than the budget, takes the cost
    # from the value rather than from the caller, and needs the lock around it all the same.

    def __init__(self, budget_bytes: int) -> None:
        self.budget_bytes = budget_bytes
        self.used_bytes = 0
        self._entries: OrderedDict[Hashable, tuple[Any, int]] = OrderedDict()
        self._lock = RLock()

    def __len__(self) -> int:
        return len(self._entries)

    def get(self, key: Hashable, make: Callable[[], T], cost_bytes: int) -> T:
        """Return the entry of `key`, made by `make` when it is not there."""
        with self._lock:
            if key in self._entries:
                self._entries.move_to_end(key)
                kept: T = self._entries[key][0]
                return kept
        # Outside the lock: two threads may both make it, and the first one in stays.
        made = make()
        with self._lock:
            if key not in self._entries:
                self._entries[key] = made, cost_bytes
                self.used_bytes += cost_bytes
            while self.used_bytes > self.budget_bytes and len(self._entries) > 1:
                self.used_bytes -= self._entries.popitem(last=False)[1][1]
        return made

    def clear(self) -> None:
        """Forget everything."""
        with self._lock:
            self._entries.clear()
            self.used_bytes = 0

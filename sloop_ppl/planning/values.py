"""Actions, states and observations of the search: immutable, cheaply hashed pomdp-py values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NoReturn, Protocol

from sloop_ppl.planning._pomdp import Action, ObjectState, Observation, OOState

__all__ = ["RobotState", "SearchAction", "SearchObservation", "SearchState", "TargetState"]


def _refuse(self: object, *_: object) -> NoReturn:
    raise AttributeError(f"{type(self).__name__} is immutable; make a new one")


class _Space(Protocol):
    """What a robot's state asks of the `SearchSpace` that made it."""

    target_ids: tuple[str, ...]
    n_cols: int

    def decode(self, number: int) -> tuple[int, int, int]:
        """Return row, column and heading of a pose."""
        ...

    def is_over(self, found: int, finds: int) -> bool:
        """Tell whether the search ends."""
        ...

    def view(self, pose: int) -> frozenset[int]:
        """Return the cells in view from a pose."""
        ...

    def preferences(self, pose: int) -> tuple[bytes, int, int]:
        """Return how the preferred moves are looked up."""
        ...

    def moved(self, index: int, pose: int) -> tuple[int, bool]:
        """Return the most probable pose after a move, and whether the robot collides."""
        ...

    def robot(
        self,
        pose: int,
        found: int = 0,
        finds: int = 0,
        looked: bool = False,
        collided: bool = False,
    ) -> RobotState:
        """Return the robot at a pose."""
        ...


def _same(self: Any, _memo: object = None) -> Any:
    return self


def _differs(self: object, other: object) -> bool:
    return not self.__eq__(other)


class SearchAction(Action):
    """One of the actions; there is one object per name, index and target.

    Attributes
    ----------
    name
        Name, such as ``"forward"``, ``"find"`` or ``"find(RedBike)"``.
    index
        Position in the declared order of actions.
    marks
        Bit mask of the targets that a find marks when they are in view; 0 for a move.
    """

    __slots__ = ("_hash", "index", "marks", "name")
    name: str
    index: int
    marks: int

    def __init__(self, name: str, index: int, marks: int = 0) -> None:
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "index", index)
        object.__setattr__(self, "marks", marks)
        # marks has 10 bits, see MAX_TARGETS; other parts of a hash are mixed by Python itself.
        object.__setattr__(self, "_hash", index * 1024 + marks)

    __setattr__ = _refuse
    __copy__ = __deepcopy__ = _same
    __ne__ = _differs  # pomdp-py has one of its own, which would stay

    def __eq__(self, other: object) -> bool:
        return self is other or (
            isinstance(other, SearchAction)
            and (self.name, self.index, self.marks) == (other.name, other.index, other.marks)
        )

    def __hash__(self) -> int:
        return self._hash  # type: ignore[no-any-return, attr-defined]

    def __repr__(self) -> str:
        return self.name

    __str__ = __repr__

    def __reduce__(self) -> tuple[Any, ...]:
        return SearchAction, (self.name, self.index, self.marks)


class RobotState(ObjectState):
    """Where the robot is and what it has done; made by :meth:`SearchSpace.robot`, one per value.

    Attributes
    ----------
    pose
        ``(row * n_cols + col) * 8 + heading``.
    found
        Bit mask of the targets found so far.
    finds
        How many finds were taken.
    looked
        True once the robot has sensed from its pose; a find before that counts for nothing.
    collided
        True when the last move was stopped by a no-fly building.
    ended
        True when the search is over.
    view
        The cells in view, as flat indices.
    """

    __slots__ = (
        "_hash",
        "_next",
        "_prefer",
        "_space",
        "collided",
        "ended",
        "finds",
        "found",
        "looked",
        "pose",
        "view",
    )
    pose: int
    found: int
    finds: int
    looked: bool
    ended: bool
    collided: bool
    view: frozenset[int]
    _space: _Space
    _next: list[RobotState | None]
    _prefer: tuple[bytes, int, int] | None

    def __init__(
        self,
        space: _Space,
        pose: int,
        found: int,
        finds: int,
        looked: bool,
        collided: bool = False,
    ) -> None:
        row, col, heading = space.decode(pose)
        attributes = {
            "cell": (row, col),
            "heading": heading,
            "found": found,
            "finds": finds,
            "looked": looked,
            "collided": collided,
        }
        super().__init__("robot", attributes)
        derived = {
            "pose": pose,
            "found": found,
            "finds": finds,
            "looked": looked,
            "ended": space.is_over(found, finds),
            "collided": collided,
            "view": space.view(pose),
            "_space": space,
            # Successors are kept: a rollout asks for the same moves again and again.
            "_next": [None] * 3,
            "_prefer": None,  # looked up by the first rollout that asks: large on large maps
            "_hash": hash((pose, found, finds, looked, collided)),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    __setattr__ = _refuse
    __setitem__ = _refuse
    __copy__ = __deepcopy__ = copy = _same
    __ne__ = _differs

    @property
    def preferences(self) -> tuple[bytes, int, int]:
        """How the moves preferred from here are looked up; see `SearchSpace.preferences`."""
        if self._prefer is None:
            object.__setattr__(self, "_prefer", self._space.preferences(self.pose))
        found: tuple[bytes, int, int] = self._prefer  # type: ignore[assignment]
        return found

    @property
    def cell(self) -> tuple[int, int]:
        """``(row, col)`` of the robot's cell."""
        return self._space.decode(self.pose)[:2]

    @property
    def heading(self) -> int:
        """Direction the robot faces, eighths of a turn anticlockwise from east."""
        return self.pose & 7

    def moved(self, index: int) -> RobotState:
        """Return the robot after the likeliest outcome of a move (0 forward, 1 left, 2 right)."""
        after = self._next[index]
        if after is None:
            after = self.at(*self._space.moved(index, self.pose))
            self._next[index] = after
        return after

    def at(self, pose: int, collided: bool = False) -> RobotState:
        """Return the robot after a move that led to a pose."""
        return self._space.robot(pose, self.found, self.finds, looked=True, collided=collided)

    def with_view(self, view: frozenset[int]) -> RobotState:
        """Return the robot between cells, where it sees other cells than from the middle of one."""
        values = self.pose, self.found, self.finds, self.looked, self.collided
        other = RobotState(self._space, *values)
        object.__setattr__(other, "view", view)
        return other

    def marked(self, marks: int) -> RobotState:
        """Return the robot after a find that marks the targets of a bit mask."""
        return self._space.robot(self.pose, self.found | marks, self.finds + 1, self.looked)

    def __eq__(self, other: object) -> bool:
        return self is other or (
            isinstance(other, RobotState)
            and self.pose == other.pose
            and self.found == other.found
            and self.finds == other.finds
            and self.looked == other.looked
            and self.collided == other.collided
        )

    def __hash__(self) -> int:
        return self._hash  # type: ignore[no-any-return, attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        values = self.pose, self.found, self.finds, self.looked, self.collided
        return _robot, (self._space, *values)


def _robot(space: _Space, *values: Any) -> RobotState:
    return space.robot(*values)


class TargetState(ObjectState):
    """Where one target is."""

    __slots__ = ()

    def __init__(self, target_id: str, row: int, col: int) -> None:
        super().__init__("target", {"id": target_id, "cell": (row, col)})

    __setitem__ = _refuse
    __copy__ = __deepcopy__ = copy = _same
    __ne__ = _differs

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TargetState) and self.attributes == other.attributes

    def __hash__(self) -> int:
        return hash(self.attributes["cell"])

    def __reduce__(self) -> tuple[Any, ...]:
        return TargetState, (self.attributes["id"], *self.attributes["cell"])


class SearchState(OOState):
    """The robot's state and the cell of every target.

    Attributes
    ----------
    robot
        The robot.
    cells
        Flat index ``row * n_cols + col`` of each target's cell, in the order of the ids.
    """

    __slots__ = ("cells", "robot")
    robot: RobotState
    cells: tuple[int, ...]

    def __init__(self, robot: RobotState, cells: tuple[int, ...]) -> None:
        _set_robot(self, robot)
        _set_cells(self, cells)

    __setattr__ = _refuse
    __copy__ = __deepcopy__ = copy = _same
    __ne__ = _differs

    @property
    def object_states(self) -> Mapping[str, ObjectState]:
        """The state of each object by id: ``"robot"`` and the targets."""
        space = self.robot._space
        targets = {
            name: TargetState(name, *divmod(cell, space.n_cols))
            for name, cell in zip(space.target_ids, self.cells, strict=True)
        }
        return {"robot": self.robot, **targets}

    @property
    def situation(self) -> frozenset[tuple[str, ObjectState]]:
        """What identifies the state."""
        return frozenset(self.object_states.items())

    def get_object_state(self, objid: str) -> ObjectState:
        """Return the state of one object."""
        return self.object_states[objid]

    s = get_object_state

    def get_object_class(self, objid: str) -> str:
        """Return ``"robot"`` or ``"target"``."""
        return str(self.object_states[objid].objclass)

    def get_object_attribute(self, objid: str, attr: str) -> Any:
        """Return one attribute of one object."""
        return self.object_states[objid].attributes[attr]

    set_object_state = _refuse

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, SearchState)
            and self.robot == other.robot
            and self.cells == other.cells
        )

    def __hash__(self) -> int:
        return hash((self.robot, self.cells))

    def __repr__(self) -> str:
        return f"SearchState({dict(self.object_states)})"

    __str__ = __repr__

    def __reduce__(self) -> tuple[Any, ...]:
        return SearchState, (self.robot, self.cells)


# The slots themselves, for speed: states are made by the million, and __setattr__ refuses.
_set_robot: Callable[[SearchState, RobotState], None] = SearchState.__dict__["robot"].__set__
_set_cells: Callable[[SearchState, tuple[int, ...]], None] = SearchState.__dict__["cells"].__set__


class SearchObservation(Observation):
    """What one step showed.

    Parameters
    ----------
    seen
        Report of each target: the flat index of the cell at which it was seen, or -1; of a sensor
        that sees no mask, whatever it reports, hashable.
    found
        Bit mask of the targets found so far; a find shows its outcome.
    pose
        Number of the pose that was reached, where moves may slip; else -1.
    some
        Whether some target was seen; from `seen` when None.
    """

    __slots__ = ("_hash", "any", "found", "pose", "seen")
    seen: tuple[Any, ...]
    found: int
    pose: int
    any: bool

    def __init__(
        self, seen: tuple[Any, ...], found: int, pose: int = -1, *, some: bool | None = None
    ) -> None:
        object.__setattr__(self, "seen", seen)
        object.__setattr__(self, "found", found)
        object.__setattr__(self, "pose", pose)
        object.__setattr__(self, "any", max(seen) >= 0 if some is None else some)
        object.__setattr__(self, "_hash", hash((seen, found, pose)))

    __setattr__ = _refuse
    __copy__ = __deepcopy__ = _same
    __ne__ = _differs

    def __eq__(self, other: object) -> bool:
        return self is other or (
            isinstance(other, SearchObservation)
            and self.seen == other.seen
            and self.found == other.found
            and self.pose == other.pose
        )

    def __hash__(self) -> int:
        return self._hash  # type: ignore[no-any-return, attr-defined]

    def __repr__(self) -> str:
        return f"SearchObservation(seen={self.seen}, found={self.found:b})"

    __str__ = __repr__

    def __reduce__(self) -> tuple[Any, ...]:
        return _observation, (self.seen, self.found, self.pose, self.any)


def _observation(seen: tuple[Any, ...], found: int, pose: int, some: bool) -> SearchObservation:
    return SearchObservation(seen, found, pose, some=some)

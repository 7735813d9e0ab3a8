"""The log evidence, a number that knows what it may be compared with."""

from __future__ import annotations

from collections.abc import Sequence

from sloop_ppl.errors import InputError

__all__ = ["LogEvidence"]


class LogEvidence(float):
    """A log probability of what was said, with the meaning it has under its model.

    It is a float, except that asking which of two is greater raises InputError when the two do
    not measure the same thing: models are ranked by evidence only when each gives a probability
    to what was said out of one vocabulary (``normalisation="speaker"``).

    Parameters
    ----------
    value
        Log probability, natural.
    normalisation
        That of the model.
    model
        The model's name.
    vocabulary
        Relation words that could have been said; empty unless the normalisation is ``"speaker"``.

    Examples
    --------
    >>> a, b = (LogEvidence(-2.0, "map", name) for name in ("sloop", "bayes"))
    >>> a > b
    Traceback (most recent call last):
    ...
    sloop_ppl.errors.InputError: Log evidence of model 'sloop' ('map' normalisation) and of \
'bayes' ('map') cannot be ranked; expected 'speaker' normalisation over one vocabulary: only \
then do both give a probability to the same words
    """

    normalisation: str
    model: str
    vocabulary: tuple[str, ...]

    def __new__(
        cls, value: float, normalisation: str, model: str, vocabulary: Sequence[str] = ()
    ) -> LogEvidence:
        """Return a float that carries its meaning."""
        made = super().__new__(cls, value)
        made.normalisation, made.model = normalisation, model
        made.vocabulary = tuple(vocabulary) if normalisation == "speaker" else ()
        return made

    def __getnewargs__(self) -> tuple[float, str, str, tuple[str, ...]]:  # type: ignore[override]
        return float(self), self.normalisation, self.model, self.vocabulary

    def __lt__(self, other: float) -> bool:
        self._check(other)
        return float.__lt__(self, other)

    def __le__(self, other: float) -> bool:
        self._check(other)
        return float.__le__(self, other)

    def __gt__(self, other: float) -> bool:
        self._check(other)
        return float.__gt__(self, other)

    def __ge__(self, other: float) -> bool:
        self._check(other)
        return float.__ge__(self, other)

    def _check(self, other: float) -> None:
        if not isinstance(other, LogEvidence) or self.model == other.model:
            return
        both = {self.normalisation, other.normalisation} == {"speaker"}
        if not both or self.vocabulary != other.vocabulary:
            raise InputError(
                f"Log evidence of model '{self.model}' ('{self.normalisation}' normalisation) and "
                f"of '{other.model}' ('{other.normalisation}') cannot be ranked; expected "
                "'speaker' normalisation over one vocabulary: only then do both give a "
                "probability to the same words"
            )

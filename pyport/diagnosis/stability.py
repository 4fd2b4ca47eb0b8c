"""How often a name came back when it was chosen again on resampled data, and what that decides."""

from __future__ import annotations

from dataclasses import dataclass, field

from pyport.thresholds import MOSTLY, NOTICEABLE, STABLE


@dataclass(frozen=True)
class Stability:
    """How often a name came first.

    Attributes
    ----------
    resampled
        What was drawn: sessions, blocks of time or pointings.
    draws, kept
        How often, and in how many the name, or one of its class, came first.
    names
        Other names that came first, and in how many draws, the most frequent first.
    """

    resampled: str
    draws: int
    kept: int
    names: dict[str, int] = field(default_factory=dict)

    @property
    def stable(self) -> bool:
        """Tell whether the name survives."""
        return self.kept >= STABLE * self.draws

    @property
    def nameless(self) -> int:
        """Return in how many draws nothing was worth a name."""
        return self.draws - self.kept - sum(self.names.values())

    @property
    def instead(self) -> str | None:
        """Return the name that came first most often where it did not, None for no name."""
        most = max(self.names, key=lambda name: self.names[name], default=None)
        return most if most is not None and self.names[most] >= self.nameless else None

    @property
    def returned(self) -> tuple[str, ...]:
        """Return the other names that came first in a noticeable share of the draws."""
        return tuple(n for n, count in self.names.items() if count >= NOTICEABLE * self.draws)

    def verdict(self, verdict: str) -> str:
        """Return what a verdict becomes: the data decide between names only if they keep doing so.

        A name that is not stable is `ambiguous` with those that came back, or `unknown` where
        mostly none did.
        """
        if self.stable or verdict == "unknown":
            return verdict
        return "unknown" if self.nameless > MOSTLY * self.draws else "ambiguous"

    @property
    def counts(self) -> str:
        """Return how often which name came first."""
        others = [f"{name} in {count}" for name, count in self.names.items()]
        if self.nameless:
            others.append(f"no name in {self.nameless}")
        first = f"the name came back in {self.kept} of {self.draws} draws"
        return ", ".join([first, *others])

    @property
    def words(self) -> str:
        """Return how often the name came back, and what came in its place."""
        said = f"resampling {self.resampled}, {self.counts}"
        return said if self.stable else f"not stable: {said}"

"""Blocks of the data, and who shares a coefficient."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Codes


@dataclass(frozen=True)
class Blocks:
    """The blocks of the data: one for each antenna in each session."""

    antenna: NDArray[np.str_]
    session: NDArray[np.str_]

    def __len__(self) -> int:
        """Return the number of blocks."""
        return len(self.antenna)

    @cached_property
    def antennas(self) -> int:
        """Return the number of antennas."""
        return len(np.unique(self.antenna))

    def groups(self, scope: str) -> Codes:
        """Give blocks that share a coefficient the same number."""
        labels = {
            "all": np.zeros(len(self), int),
            "session": self.session,
            "antenna": self.antenna,
            "antenna and session": np.arange(len(self)),
        }[scope]
        return np.unique(labels, return_inverse=True)[1]

    def names(self, scope: str) -> list[str]:
        """Name the groups of a scope, in their order."""
        if scope == "all":
            return [""]
        if scope == "antenna and session":
            return [f"{a} {s}".strip() for a, s in zip(self.antenna, self.session, strict=True)]
        return [str(one) for one in np.unique(getattr(self, scope))]

    def scopes(self) -> list[str]:
        """Return the scopes that differ from each other here, the smallest first."""
        several = self.antennas > 1, len(np.unique(self.session)) > 1
        wanted = {"all": True, "session": several[1], "antenna": several[0]}
        found = [scope for scope, there in wanted.items() if there]
        return [*found, "antenna and session"] if all(several) else found

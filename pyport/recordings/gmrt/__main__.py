"""Make the recordings in data/ anew from the printed tables: python -m pyport.recordings.gmrt."""

from __future__ import annotations

import numpy as np

from pyport.recordings.formats import csv
from pyport.recordings.gmrt import DATA, NAMES, build, published
from pyport.recordings.gmrt.sessions import SESSIONS
from pyport.recordings.tabulate import Table


def main() -> None:
    """Write every file of recordings."""
    made = {session.date: build.columns(session) for session in SESSIONS if session.table != 13}
    for name, dates in NAMES.items():
        if name.endswith("03-31"):
            continue
        days = [made[date] for date in dates]
        joined = {key: np.array([v for day in days for v in day[key]]) for key in days[0]}
        csv.write(Table(build.header(), joined), DATA / f"{name}.csv")
    csv.write(published.table(), published.FILE)


if __name__ == "__main__":
    main()

"""Drawn nights for the tests of the watch."""

import numpy as np

from pyport.examiner.nights import nights


def world(number=12, *, step=True, kind="white"):
    """Return drawn past and watched recordings; number 12 has a tilt of three sigmas."""
    return nights.draw(nights.Case(kind, number, 1, step=step))


def text(table, header):
    """Return recordings as CSV: the header's lines and the lines of rows."""
    above = [f"# {key}: {value}\n" for key, value in header.items()]
    above.append(",".join(table) + "\n")
    cells = [
        [str(one) for one in (np.datetime_as_string(c) if c.dtype.kind == "M" else c.tolist())]
        for c in table.values()
    ]
    return above, [",".join(row) + "\n" for row in zip(*cells, strict=True)]


def write(path, table, header):
    """Write recordings as CSV."""
    above, rows = text(table, header)
    path.write_text("".join(above + rows))
    return path

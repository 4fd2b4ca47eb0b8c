"""What the page on parity says of the RT32's routines alone: docs/parity.md."""

from __future__ import annotations

import re
from pathlib import Path

import rt32_digits

from pyport.parity.report import markdown_table

INTRODUCTION = """\
# Is the port the program that was published?

*Generated; `make parity-report` writes it again and the tests fail when it is stale.*

Three routines were published: `Model` (exact), `ModelA` (approximate) and `Hjump`. They are
compiled from their text (see `legacy_fortran/README.md`); both ports are held to what they
answer.

- `pyport.legacy` follows the text statement by statement and must equal the reference build **bit
  for bit**, infinities, NaN and signed zeros included.
- `pyport.pointing` is vectorised and keeps REAL*8 throughout. It must stay within **N ulp of
  REAL*4** beyond the oracle's own spread: what the reference answers with an input one ulp away,
  and what the same text answers with every REAL*4 promoted to REAL*8. The ledger below lists
  where even that is not enough, and why.
"""

DIGITS = """\
The text leaves open what a compiler did with `DSIN(Alt)` and its kin, which take REAL*8 only:
convert the argument, or promote every REAL*4. The page prints six rows of the table to 1e-7 deg,
and they tell. `Model` stores the azimuth offset in the REAL*4 `dAz` while it may still be a turn
too large; near 360 deg neighbouring REAL*4 are 2^-15 deg = 0.0000305 deg apart, so that after the
turn is taken off the answer is a multiple of 2^-15 deg. A promoted `dAz` never is.
"""

DIGITS_VERDICT = """\
**The printed digits are those of the program that converts its arguments and keeps `dAz` in
REAL*4, called with azimuths reduced to ±180 deg.** Both rows at azimuth 270 are multiples of
2^-15 deg to their last printed digit, and the reference, called with -90 deg, prints them
exactly; by accident that happens once in 90,000 times. The promoted program misses them by a
hundred units of the last digit whatever the parameters; called with the azimuth as it stands in
the table, the converted one would have to print multiples of 2^-15 deg in the four rows at -270 and
-269, which are none. What is left, 2 units of the last digit at zenith distances -5 and -4, is
no rounding: behind the zenith the program took the tilt in a way of its own, equal to Model's to
first order (`docs/steering-table.md`).

So the reference build here is the argument-converting one. `Hjump` is not periodic: a table made
with reduced azimuths has its jump, beyond ±180 deg, where the curve at the reduced azimuth puts
it.
"""


def introduction() -> str:
    """Return the head of the page."""
    return INTRODUCTION


def derivation() -> str:
    """Return where the bounds come from, as the comment above the vectorised port says it."""
    text = Path(__file__).with_name("parity.toml").read_text(encoding="utf-8")
    comment = re.search(r"((?:#.*\n)+)\[\[port\]\]\nname = \"vectorised\"", text)
    if comment is None:
        raise ValueError("no comment above the port")
    return "\n".join(line.lstrip("#").removeprefix(" ") for line in comment[1].splitlines())


def sections() -> str:
    """Return the section on the published digits."""
    title = "## Which program made the published digits\n"
    return f"{title}\n{DIGITS}\n{_digits()}\n{DIGITS_VERDICT}"


def _digits() -> str:
    tried = rt32_digits.hypotheses()
    az_deg, zd_deg, numbers = rt32_digits.printed_rows()
    rows = []
    for i, (az, zd, number) in enumerate(zip(az_deg, zd_deg, numbers, strict=True)):
        cells = [f"{h.answers_deg[i]:.7f}" + (" *" if h.coarse[i] else "") for h in tried]
        in_steps = f"{number / rt32_digits.STEP_DEG:.3f}"
        rows.append([f"{az:.0f}", f"{zd:.0f}", f"{number:.7f}", in_steps, *cells])
    heads = ["Az", "z", "printed", "in 2^-15 deg", *(one.name for one in tried)]
    off_grid = [f"{one.off_grid_deg:.1e}" if one.coarse.any() else "-" for one in tried]
    blank = ["", "", "", ""]
    rows.append(["rows marked * off a multiple of 2^-15 by", *blank[1:], *off_grid])
    missed = [f"{one.violation_deg:.1e}" for one in tried]
    rows.append(["missed by, whatever the parameters", *blank[1:], *missed])
    return (
        markdown_table(heads, rows)
        + "\nAll in degrees; * marks answers that are a multiple of 2^-15 deg since a turn was "
        "taken off. The last row is a linear programme over all parameters that print as Model3 "
        "was printed.\n"
    )

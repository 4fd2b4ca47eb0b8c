"""Mean places of catalogues: from their equinox to J2000, as the sky has them."""

from __future__ import annotations

from dataclasses import dataclass

#: An equinox before this year is Besselian where no letter says so (SUN/67, `sla_KBJ`).
FIRST_JULIAN = 1984.0
#: The one Besselian equinox that is read: FK4's.
FK4_YEAR = 1950.0


@dataclass(frozen=True)
class Equinox:
    """The year of an equinox, Julian or Besselian; places are of the same epoch."""

    year: float
    besselian: bool

    @property
    def known(self) -> bool:
        """Tell whether places of it can be moved: any Julian one, and B1950."""
        return not self.besselian or abs(self.year - FK4_YEAR) < 1e-3


@dataclass(frozen=True)
class Place:
    """A mean place [rad] and its proper motions, d(RA)/dt without cos Dec [rad/yr]."""

    ra: float
    dec: float
    pm_ra: float
    pm_dec: float


def equinox(word: str) -> Equinox | None:
    """Return the equinox that a word such as `B1950.0` or `2000` says, None for another word."""
    letter = word[:1].upper()
    try:
        year = float(word[1:] if letter in {"B", "J"} else word)
    except ValueError:
        return None
    if not 1800 < year < 2200:
        return None
    return Equinox(year, letter == "B" or (letter != "J" and year < FIRST_JULIAN))


def to_j2000(place: Place, of: Equinox) -> Place:
    """Return a mean place at equinox and epoch J2000, within 0.03 arcsec of the ICRS.

    FK4 places by ERFA's `fk425` (Standish 1982, Aoki et al. 1983: E-terms, precession and the
    motion of the equinox), those of a Julian equinox by the IAU 2006 precession.
    """
    import erfa

    if of.besselian:
        moved = erfa.fk425(place.ra, place.dec, place.pm_ra, place.pm_dec, 0.0, 0.0)
        return Place(*map(float, moved[:4]))
    if abs(of.year - 2000) < 1e-3:
        return place
    matrix = erfa.pmat06(*erfa.epj2jd(of.year))
    there = erfa.s2pv(place.ra, place.dec, 1.0, place.pm_ra, place.pm_dec, 0.0)
    ra, dec, _, pm_ra, pm_dec, _ = map(float, erfa.pv2s(erfa.trxpv(matrix, there)))
    years = 2000 - of.year
    return Place(ra + years * pm_ra, dec + years * pm_dec, pm_ra, pm_dec)

"""Every column of recordings, once: its names here and in files, its unit, what others call it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from pyport.angles import ARCMIN, DEG, HOUR, RADIANS_PER
from pyport.mounts import KINDS

ANGLE, NUMBER, LABEL, TEXT = "angle", "number", "label", "text"


@dataclass(frozen=True)
class Column:
    """A column of the contract."""

    name: str  #: inside the program: angles and rates without a unit
    words: str  #: as an axis of a picture says it
    kind: str = ANGLE
    unit: str = "deg"  #: of its numbers, as the files have them
    scale: float = DEG  #: the program's numbers (radians, seconds) in one such unit
    written: str = ""  #: in files, unit and all; `name` where nothing else is said
    shown: tuple[str, float] = ("", 1.0)  #: unit and scale of pictures, where they are others
    spoken: str = ""  #: without a unit, where one may come as a Quantity or a column's unit
    quantity: str = ""  #: the unit as astropy spells it
    circular: bool = False  #: whether its mean is that of directions
    weather: bool = False  #: whether it may move a telescope
    also: tuple[str, ...] = ()  #: what a file may call it by mistake, in small letters
    called: str = ""  #: a pattern of what tables of other programs call it, without a unit

    @property
    def spelled(self) -> str:
        """Return its name in files."""
        return self.written or self.name


def _angle(
    name: str, words: str, unit: str = "deg", also: str = "", called: str = "", *, circular: bool
) -> Column:
    """Return an angle that conditions may name, in degrees or hours."""
    quantity = "hourangle" if unit == "h" else "deg"
    return Column(
        name,
        words,
        unit=unit,
        scale=RADIANS_PER[unit],
        written=f"{name}_{unit}",
        shown=("h", HOUR) if name == "ra" else ("", 1.0),
        spoken=name,
        quantity=quantity,
        circular=circular,
        called=called,
        also=tuple(also.split()),
    )


def _number(name: str, spoken: str, unit: str, quantity: str, also: str, called: str) -> Column:
    """Return a number whose unit is a fixed part of its name."""
    words, weather = spoken.replace("_", " "), name != "frequency_mhz"
    return Column(
        name, words, NUMBER, unit, 1.0,
        spoken=spoken, quantity=quantity, weather=weather, also=tuple(also.split()), called=called,
    )  # fmt: skip


def _label(name: str, called: str = "", also: tuple[str, ...] = ()) -> Column:
    return Column(name, name.replace("_", " "), LABEL, "", 1.0, called=called, also=also)


_OFF = "d|delta|(coll?(imation)?_?)?off(s|set)?|pnt"
_ERR = "err(ors?)?|sigma|std(dev)?|rms|unc(ertainty)?"
_AZ, _EL = "az|azm|azim(uth?)?", "el|elev(ation)?|alt|altitude"
_XEL = r"xel|az_?cos_?el?|cross(_?el(evation)?)?"
_HA, _DEC = "ha|hour_?angle", "dec|decl(ination)?"


def _offset(axis: str, behind: str) -> str:
    """Return the pattern of an offset along one of the axes, or behind one of them."""
    return rf"({_OFF})_?({axis})|({behind})_?off(s|set)?"


def _error(axis: str) -> str:
    """Return the pattern of the error of a direction or of an offset: never that of an offset."""
    return (
        rf"({_ERR}|e)_?(({_OFF})_?)?({axis})"
        rf"|(({_OFF})_?)?({axis})_?(off(s|set)?_?)?({_ERR})"
    )


SCAN_RATE_UNIT = ARCMIN / 60
TIME = "time_utc"
#: A day and an hour of it, which together are a time.
DAY, HOUR_OF_DAY = "date_utc", "ut_h"
SCAN_RATE = "scan_rate_arcmin_per_min"
#: Why a row is not to be used, blank where it is.
SET_ASIDE = "set_aside"

#: In the order in which patterns are tried. Axes of mounts and offsets from them that are not here
#: are added from the mounts.
COLUMNS: tuple[Column, ...] = (
    Column(
        "az", "azimuth", written="az_deg",
        also=("azimuth", "azimuth_deg", "azimut", "az_true_deg"),
        called=rf"({_AZ})d?|az_?(true|cmd|obs)",
    ),
    Column(
        "el", "elevation", written="el_deg",
        also=(
            *("elevation", "elevation_deg", "alt", "alt_deg", "altitude", "altitude_deg"),
            "el_true_deg",
        ),
        called=rf"({_EL})d?|el_?(true|cmd|obs)",
    ),
    Column(
        "d_xel", "cross-elevation offset",
        also=("dxel", "d_x", "d_cross_el", "d_xelev", "delta_xel", "dcross", "d_cross"),
        called=rf"{_offset(f'x|{_XEL}', _XEL)}|az_?cos_?el",
    ),
    Column(
        "d_az", "azimuth offset",
        also=("daz", "d_azimuth", "d_azim", "delta_az"),
        called=_offset(_AZ, _AZ),
    ),
    Column(
        "d_el", "elevation offset",
        also=("d_alt", "dalt", "del", "d_elevation", "d_elev", "delta_el", "delta_alt"),
        called=_offset(f"y|{_EL}", _EL),
    ),
    Column(
        "d_zd", "zenith distance offset",
        also=("dzd", "d_za", "d_zenith_distance", "delta_zd"),
        called=rf"({_OFF})_?(zd|za|zenith(_?distance)?)",
    ),
    Column(
        "d_ha", "hour angle offset",
        also=("dha", "d_hour_angle", "delta_ha"), called=_offset(_HA, _HA),
    ),
    Column(
        "d_dec", "declination offset",
        also=("ddec", "d_declination", "delta_dec"), called=_offset(_DEC, _DEC),
    ),
    Column("sigma_xel", "error across", called=_error(f"x|{_XEL}")),
    Column("sigma_az", "error of azimuth", called=_error(_AZ)),
    Column("sigma_el", "error of elevation", called=_error(f"y|{_EL}")),
    _label("source", "source|target|object|star|name|src"),
    _label("session", "session|night|run|dataset"),
    _label("antenna", "antenna|ant|dish|telescope"),
    _label("receiver"),
    _label("channel"),
    _label("polarisation", also=("polarization", "pol")),
    _label("scan_axis"),
    _label("pier_side", r"pier(_?side)?|side(_?of_?pier)?"),
    Column(
        "time", "time", TEXT, "", 1.0, written=TIME,
        also=("utc", "time_iso", "time_ut", "datetime_utc", "date_obs"),
        called=r"time(stamp)?(_?(utc?|iso))?|utc?|date_?obs|date_?time",
    ),
    Column(DAY, "day", TEXT, "", 1.0, called=r"date(_?utc?)?|day"),
    Column(HOUR_OF_DAY, "hour of the day", NUMBER, "h", 1.0, called=r"ut(h|_?hours?)"),
    _number(
        "temperature_c", "temperature", "°C", "deg_C",
        "temperature temp_c temperature_deg_c air_temperature_c",
        r"t_?(amb|air|out)|temp(erature)?(_?(c|amb|air|out))?",
    ),
    _number(
        "pressure_hpa", "pressure", "hPa", "hPa",
        "pressure pressure_mbar pressure_mb",
        r"press(ure)?(_?(hpa|mb(ar)?))?",
    ),
    _number(
        "humidity_pct", "humidity", "%", "percent",
        "humidity humidity_percent relative_humidity_pct",
        r"(r|rel_?)?hum(idity)?(_?(pct|percent))?|rh",
    ),
    _number(
        "wind_speed_m_s", "wind_speed", "m/s", "m/s",
        "wind_speed wind_m_s wind_speed_ms",
        r"wind_?(speed|vel)?(_?m_?s)?",
    ),
    _angle(
        "wind_az", "azimuth of the wind", circular=True,
        also="wind_direction_deg wind_dir_deg wind_azimuth_deg",
        called=r"wind_?(az|dir(ection)?)(_?deg)?",
    ),
    _number(
        "frequency_mhz", "frequency", "MHz", "MHz", "frequency freq_mhz", r"freq(uency)?(_?mhz)?"
    ),
    _angle("sun_az", "azimuth of the Sun", circular=True),
    _angle("sun_el", "elevation of the Sun", circular=False),
    _angle("ra", "right ascension", circular=True),
    _angle("dec", "declination", called=rf"({_DEC})d?", circular=False),
    _angle("hour_angle", "hour angle", "h", called=_HA, circular=True),
    Column("scan_direction", "scan direction", NUMBER, "", 1.0),
    Column(
        "scan_rate", "scan rate", NUMBER, "arcmin/min", SCAN_RATE_UNIT,
        written=SCAN_RATE, spoken="scan_rate", quantity="arcmin/min",
    ),
)  # fmt: skip

#: Angles of the axes of mounts, and offsets from them.
AXES = frozenset(axis.column for mount in KINDS.values() for axis in mount.axes)
_OFFSETS = {
    name
    for mount in KINDS.values()
    for name in (mount.first.offset, mount.across_column, mount.second.offset)
}


def _kind(kind: str) -> Iterator[Column]:
    return (one for one in COLUMNS if one.kind == kind)


#: Angles: each is a column `NAME_UNIT`, for instance `az_deg` or `d_el_arcmin`.
ANGLES = frozenset(
    {
        *AXES,
        *_OFFSETS,
        *(f"sigma_{one.removeprefix('d_')}" for one in _OFFSETS),
        *(one.name for one in _kind(ANGLE)),
    }
)
#: Angles beside az and el that are kept as columns.
DIRECTIONS = (AXES | {one.name for one in _kind(ANGLE) if one.spoken}) - {"az", "el"}
#: Short names of angles.
ALIASES = {"ha": "hour_angle"}
#: Angles that are also given in hours.
HOURLY = frozenset({"hour_angle", "ra"})
#: Numbers whose unit is a fixed part of their name.
NUMBERS = frozenset(one.name for one in _kind(NUMBER) if one.name not in {"scan_rate", HOUR_OF_DAY})
#: Labels, kept as text even where they look like numbers.
LABELS = frozenset(one.name for one in _kind(LABEL))
#: Columns that are kept without a unit -> how the contract spells them, unit and all.
SPELLED = {
    **{axis: f"{axis}_deg" for axis in AXES},
    **{one.name: one.written for one in COLUMNS if one.written},
}
#: Names inside the program that a file cannot use without saying a unit.
RESERVED = {"time": TIME, "scan_rate": SCAN_RATE}
#: Columns by what they are called without a unit, where one comes beside the numbers.
QUANTITIES = {one.spoken: one for one in COLUMNS if one.spoken}


def first_double(names: Iterable[str]) -> str | None:
    """Return the first name that stands there a second time."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None


def shown(name: str) -> tuple[str, str, float]:
    """Return how a picture calls a column: words, unit, and the program's numbers in one of it."""
    for one in COLUMNS:
        if one.name == name:
            unit, scale = one.shown if one.shown[0] else (one.unit, one.scale)
            return one.words, unit, scale
    return name, "", 1.0


def angle_of(name: str) -> tuple[str, float] | None:
    """Return the angle that a column `NAME_UNIT` holds and the radians in one of its units.

    None where the name is no angle of the contract.
    """
    quantity, _, unit = name.rpartition("_")
    quantity = ALIASES.get(quantity, quantity)
    if quantity not in ANGLES or unit not in RADIANS_PER:
        return None
    if unit == "h" and quantity not in HOURLY:
        return None
    return quantity, RADIANS_PER[unit]

"""What a file says against itself is said, and the file is read all the same."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import erfa
import numpy as np
import pytest

import pyport
from pyport.recordings import read
from pyport.recordings.notes import times
from pyport.recordings.raw import FileOptions

LATITUDE_DEG, LONGITUDE_DEG, ROWS = 50.5, 6.9, 60
SITE = "the site is at latitude"
RNG = np.random.default_rng(4)
DEC = np.arcsin(RNG.uniform(np.sin(np.radians(20)), np.sin(np.radians(80)), ROWS))
HOUR_ANGLE = RNG.uniform(-1.5, 1.5, ROWS)
OFFSETS = RNG.normal(0, 60, (2, ROWS)).round(2)


def recorded(
    path: Path,
    *,
    hours: float = 0,
    from_deg: float = 0,
    latitude: float = 1,
    longitude: float = 1,
    ra: float = 0,
) -> tuple[str, ...]:
    """Write directions with their right ascensions and times, one of them wrong; return notes."""
    lines = [
        f"# latitude_deg: {latitude * LATITUDE_DEG}",
        f"# longitude_deg: {longitude * LONGITUDE_DEG}",
        "time_utc,ra_deg,dec_deg,az_deg,el_deg,d_xel_arcsec,d_el_arcsec",
    ]
    for n in range(ROWS):
        time = datetime(2024, 1, 1, 18, tzinfo=UTC) + timedelta(minutes=10 * n)
        day = 2440587.5, time.timestamp() / 86400
        sidereal = erfa.gmst06(*day, *day) + np.radians(LONGITUDE_DEG)
        az, el = erfa.hd2ae(HOUR_ANGLE[n], DEC[n], np.radians(LATITUDE_DEG))
        place = np.degrees([sidereal - HOUR_ANGLE[n] + ra, DEC[n], az, el])
        place[[0, 2]] = (place[[0, 2]] - [0, from_deg]) % 360
        told = (time + timedelta(hours=hours)).strftime("%Y-%m-%dT%H:%M:%S")
        lines.append(",".join([told, *map(str, place), *map(str, OFFSETS[:, n])]))
    path.write_text("\n".join(lines) + "\n")
    return read(path).notes


def by_hour_angle(path: Path, *, sign: int = 1, latitude: int = 1) -> tuple[str, ...]:
    """Write directions with their hour angles, one of them wrong; return notes."""
    lines = [f"# latitude_deg: {latitude * LATITUDE_DEG}"]
    lines.append("hour_angle_h,dec_deg,az_deg,el_deg,d_xel_arcsec,d_el_arcsec")
    az, el = erfa.hd2ae(HOUR_ANGLE, DEC, np.radians(LATITUDE_DEG))
    place = sign * HOUR_ANGLE * 12 / np.pi, *np.degrees([DEC, az, el]), *OFFSETS
    lines += [",".join(map(str, row)) for row in np.transpose(place)]
    path.write_text("\n".join(lines) + "\n")
    return read(path).notes


def test_a_sound_file_says_nothing_against_itself(tmp_path):
    """Precession, aberration and refraction are no contradiction."""
    assert recorded(tmp_path / "night.csv") == ()
    assert by_hour_angle(tmp_path / "night.csv") == ()
    assert pyport.recordings.read("gmrt-cyg-a").notes == ()


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"from_deg": 180}, "azimuth counts from south ('# azimuth_zero: south')"),
        ({"hours": 9}, "the times are 9 h ahead of UTC"),
        ({"hours": 5.5}, "the times are 5.5 h ahead of UTC"),
        ({"latitude": -1}, "the latitude has the opposite sign"),
        ({"longitude": -1}, "the longitude has the opposite sign"),
        (
            {"ra": np.radians(37.5)},
            f"{SITE} 50.5 and longitude 44.8 deg, or the times are 152 min behind UTC",
        ),
        ({"latitude": 1.1}, f"{SITE} 50.5 and longitude 7.3 deg"),
    ],
)
def test_directions_that_contradict_right_ascension_and_time(tmp_path, wrong, why):
    """The distance is said, and what makes it small."""
    (note,) = recorded(tmp_path / "night.csv", **wrong)

    assert f"(median of {ROWS} rows) from where right ascension, declination, time" in note
    assert f"deg if {why}" in note


def test_what_has_no_simple_explanation_is_said_as_well(tmp_path):
    """Azimuths that count from northeast."""
    (note,) = recorded(tmp_path / "night.csv", from_deg=45)

    assert note.endswith("time and site say")


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"sign": -1}, "the hour angle has the opposite sign"),
        ({"latitude": -1}, "the latitude has the opposite sign"),
    ],
)
def test_directions_that_contradict_the_hour_angle(tmp_path, wrong, why):
    """Without times the hour angle is compared."""
    (note,) = by_hour_angle(tmp_path / "night.csv", **wrong)

    assert "from where hour angle, declination and site say, but " in note
    assert f"0.0 deg if {why}" in note


@pytest.mark.parametrize(
    ("els", "says"),
    [
        (("20", "-5.0", "30"), ["1 row points below the horizon", "-5 deg (line 3)"]),
        (("-0.2", "-5.0", ""), ["2 rows point below the horizon", "-5 deg (line 3)"]),
        (("0", "5.0", ""), []),
    ],
)
def test_rows_below_the_horizon_are_said_and_kept(tmp_path, els, says):
    """What is right at the horizon or has no elevation is none of them."""
    path = tmp_path / "low.csv"
    rows = (f"{100 * n},{el},{n}\n" for n, el in enumerate(els))
    path.write_text("az_deg,el_deg,d_el_arcsec\n" + "".join(rows))

    found = read(path)

    assert len(found) == sum(el != "" for el in els)
    assert len(found.notes) == bool(says)
    assert all(one in found.notes[0] for one in says)


def with_pairs(path: Path, pairs: np.ndarray) -> str:
    """Write recordings of these offsets, shape (n, 2)."""
    lines = ["az_deg,el_deg,d_az_arcsec,d_zd_arcsec"]
    lines += [f"{n},{20 + n / 9},{x},{y}" for n, (x, y) in enumerate(pairs)]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


@pytest.mark.parametrize("value", [-99.99, 0.0])
def test_offsets_that_stand_for_nothing(tmp_path, value):
    """They are named as the file spells them, with what excludes them."""
    pairs = OFFSETS.T.copy()
    pairs[::7] = value
    file = with_pairs(tmp_path / "night.csv", pairs)

    (note,) = read(file).notes

    assert note.startswith(
        f"d_az_arcsec {value:g} and d_zd_arcsec {value:g} stand together in 9 of"
    )
    kept = read(file, FileOptions(where=note.split('"')[1]))
    assert (len(kept), kept.notes) == (ROWS - 9, ())


def test_offsets_that_rounding_repeats_are_no_note(tmp_path):
    """Coarse readings repeat; the most frequent is no odd one out."""
    for step in (5, 20, 60):
        pairs = np.round(RNG.normal(0, 60, (400, 2)) / step) * step
        assert read(with_pairs(tmp_path / f"{step}.csv", pairs)).notes == ()


def test_offsets_that_were_cut_off_are_said(tmp_path):
    """Readings pile up at the ends of a range that is too small, in each axis that has one."""
    pairs = RNG.normal(0, 60, (400, 2))
    pairs[:, 0] = np.clip(pairs[:, 0], -100, 120)
    low, high = (np.sum(pairs[:, 0] == end) for end in (-100, 120))

    (note,) = read(with_pairs(tmp_path / "night.csv", pairs)).notes

    assert note == (
        f"d_az_arcsec ends at -100 in {low} rows and at 120 in {high} rows: "
        "what was cut off there is only known to be at least as large"
    )


def test_three_that_are_alike_at_an_end_are_chance(tmp_path):
    """So are more where the next value has as many."""
    for alike in ([300.0] * 3, [300.0] * 5 + [299.0] * 2):
        pairs = RNG.normal(0, 60, (100, 2))
        pairs[: len(alike), 0] = alike
        assert read(with_pairs(tmp_path / "night.csv", pairs)).notes == ()


def over_nights(
    path: Path,
    late_h: float,
    sources: int = 4,
    *,
    lowest_deg: float = 40,
    step_deg: float = 5,
    spread_deg: float = 0,
) -> tuple[str, ...]:
    """Write four nights of some sources, the times of one of them wrong; return notes.

    `spread_deg`: by how much the sources stand further and further off in that night, the last.
    """
    lines = [f"# latitude_deg: {LATITUDE_DEG}"]
    lines.append("time_utc,session,source,az_deg,el_deg,d_xel_arcsec,d_el_arcsec")
    for n in range(4 * ROWS):
        night, source = n // ROWS, n % sources
        minutes = 1440 * night + 6 * (n % ROWS)
        sidereal = 2 * np.pi * 1.0027379 * minutes / 1440
        hour_angle, dec = sidereal - 0.4 * source, np.radians(lowest_deg + step_deg * source)
        hour_angle += (night == 2) * np.radians(spread_deg) * source / (sources - 1 or 1)
        az, el = np.degrees(erfa.hd2ae(hour_angle, dec, np.radians(LATITUDE_DEG)))
        time = datetime(2024, 1, 1, 18, tzinfo=UTC) + timedelta(minutes=minutes)
        time += timedelta(hours=late_h * (night == 2))
        offsets = RNG.normal(0, 60, 2).round(2)
        row = f"{time:%Y-%m-%dT%H:%M:%S},n{night},S{source}", az % 360, el, *offsets
        lines.append(",".join(map(str, row)))
    path.write_text("\n".join(lines) + "\n")
    return read(path).notes


@pytest.mark.parametrize(
    ("late_h", "says"), [(1.0, "60 min late"), (-1.0, "60 min early"), (0.05, "3 min late")]
)
def test_a_night_whose_sources_stand_elsewhere_has_wrong_times(tmp_path, late_h, says):
    """By as much as the Earth turns; which night, by how much, and which way is said."""
    (note,) = over_nights(tmp_path / "nights.csv", late_h)

    assert note.startswith("4 sources stand")
    assert "in session n2 of where they stand in others" in note
    assert note.endswith(f"its times may be {says}")


def test_one_source_that_moved_is_no_wrong_clock(tmp_path):
    """A planet moves; and sources that stand where they should say nothing."""
    assert over_nights(tmp_path / "nights.csv", 1.0, sources=1) == ()
    assert over_nights(tmp_path / "nights.csv", 0.0) == ()


def test_a_clock_is_off_by_more_than_refraction(tmp_path):
    """Half a degree, which is two minutes: a little less is not said, a little more is."""
    assert over_nights(tmp_path / "nights.csv", 1.9 / 60) == ()
    (note,) = over_nights(tmp_path / "nights.csv", 2.1 / 60)
    assert note.endswith("its times may be 2.1 min late")


@pytest.mark.parametrize(("spread_deg", "said"), [(1.2, True), (1.8, False)])
def test_sources_that_stand_elsewhere_by_different_amounts_are_no_clock(tmp_path, spread_deg, said):
    """Of 15 deg they may differ by a tenth: planets, or names that were given twice, differ."""
    notes = over_nights(tmp_path / "nights.csv", 1.0, spread_deg=spread_deg)
    assert bool(notes) == said


def test_of_many_rows_some_are_looked_at(tmp_path, monkeypatch):
    """Evenly chosen, no more than so many, and they say what all of them do."""
    most, looked_at, places = 2 * ROWS, [], times._places
    monkeypatch.setattr(times, "MOST_ROWS", most)
    monkeypatch.setattr(
        times, "_places", lambda found, *more: looked_at.append(len(found)) or places(found, *more)
    )

    (note,) = over_nights(tmp_path / "nights.csv", 1.0)

    assert note.endswith("its times may be 60 min late")
    assert most / 2 < looked_at[0] <= most


def test_near_the_pole_nothing_is_said_of_clocks(tmp_path):
    """There a right ascension is any."""
    assert over_nights(tmp_path / "nights.csv", 1.0, lowest_deg=65) != ()
    assert over_nights(tmp_path / "nights.csv", 1.0, lowest_deg=81, step_deg=1) == ()


def test_four_equal_readings_at_an_end_are_a_limit(tmp_path):
    """Where the next one stands alone."""
    pairs = RNG.normal(0, 60, (100, 2))
    pairs[:4, 0] = 300.0
    (note,) = read(with_pairs(tmp_path / "night.csv", pairs)).notes
    assert note.startswith("d_az_arcsec ends at 300 in 4 rows: ")


def test_fit_diagnosis_and_look_show_the_notes(tmp_path):
    """All of them warn."""
    file = tmp_path / "night.csv"
    (note,) = recorded(file, from_deg=180)

    for answer in (pyport.fit(file), pyport.diagnose(file), pyport.look(file)):
        assert f"arning: {note}" in " ".join(repr(answer).split())


def test_a_table_in_memory_is_noted_as_a_file_is():
    """Columns of numbers have names and units, too."""
    table = {
        "az_deg": np.arange(ROWS),
        "el_deg": np.linspace(20, 80, ROWS),
        "d_xel_arcsec": np.where(np.arange(ROWS) < 5, -99.99, OFFSETS[0]),
        "d_el_arcsec": np.where(np.arange(ROWS) < 5, -99.99, OFFSETS[1]),
    }

    assert "-99.99 stand together in 5 of 60 rows" in pyport.fit(table).summary()

"""Writing: what is written comes back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pyport.effects import Circumstances, Site
from pyport.errors import BadInput
from pyport.recordings import Recordings, SetAside, read, write


def columns_of(n, low, high):
    """Draw n numbers."""
    return arrays(float, n, elements=st.floats(low, high, allow_subnormal=False))


def gappy_columns_of(n, low, high):
    """Draw n numbers, some of them missing."""
    numbers = st.floats(low, high, allow_subnormal=False)
    return arrays(float, n, elements=numbers | st.just(np.nan))


@st.composite
def recordings(draw):
    """Draw recordings with numbers, labels, a site or none, excluded rows or none."""
    n = draw(st.integers(1, 6))
    words = arrays("U8", n, elements=st.text("abc ,\"'é", max_size=5).map(str.strip))
    columns = {
        "time": draw(arrays(float, n, elements=st.integers(0, 2**31).map(float), unique=True)),
        "source": draw(words),
        "temperature_c": draw(gappy_columns_of(n, -40, 40)),
        "scan_rate": draw(columns_of(n, 0, 1e-3)),
        "sun_az": draw(columns_of(n, 0, 6)),
    }
    site = draw(st.none() | st.just(Site(0.9, 0.3, 133.0)))
    if site is not None:
        columns |= {"hour_angle": draw(columns_of(n, -3, 3)), "dec": draw(columns_of(n, -1, 1))}
    return Recordings(
        at=Circumstances(draw(columns_of(n, -6, 12)), draw(columns_of(n, 0, 1.5)), site, columns),
        x=draw(columns_of(n, -0.01, 0.01)),
        y=draw(gappy_columns_of(n, -0.01, 0.01)),
        sigma_x=draw(gappy_columns_of(n, 1e-6, 1e-3)),
        sigma_y=np.full(n, np.nan),
        line=np.arange(n),
        file=Path("night.csv"),
        meta={"telescope": "RT32"},
        set_aside=draw(st.just(()) | st.just((SetAside(7, "no peak"),))),
    )


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".csv", ".ecsv", ".parquet"])
def test_round_trip(tmp_path_factory, suffix):
    """Every number comes back within rounding, every label and reason as it was."""
    path = tmp_path_factory.mktemp("round") / f"night{suffix}"

    @settings(max_examples=20, deadline=None)
    @given(recordings())
    def comes_back(night):
        write(night, path)
        again = read(path)

        for name in ("x", "y", "sigma_x", "sigma_y"):
            np.testing.assert_allclose(getattr(again, name), getattr(night, name), rtol=1e-14)
        np.testing.assert_allclose(again.at.az, night.at.az, rtol=1e-14)
        np.testing.assert_allclose(again.at.el, night.at.el, rtol=1e-14)
        assert again.at.columns.keys() == night.at.columns.keys()
        for name, values in night.at.columns.items():
            if values.dtype.kind == "U":
                assert again.at.column(name).tolist() == values.tolist()
            else:
                np.testing.assert_allclose(again.at.column(name), values, rtol=1e-14)
        assert (again.at.site is None) == (night.at.site is None)
        assert again.meta["telescope"] == "RT32"
        assert [aside.reason for aside in again.set_aside] == [a.reason for a in night.set_aside]

    comes_back()


def test_azimuth_from_south_is_written_from_north(tmp_path):
    """What was read from south is written from north, and says nothing else."""
    first, second = tmp_path / "south.csv", tmp_path / "north.csv"
    first.write_text("# azimuth_zero: south\naz_deg,el_deg,d_el_deg\n-90,40,0.1\n")

    night = read(first)
    write(night, second)

    assert "south" not in second.read_text()
    np.testing.assert_allclose(read(second).at.az, night.at.az)


def test_nothing_half_written(tmp_path):
    """A failure while writing leaves the old file as it was."""
    path = tmp_path / "night.csv"
    path.write_text("az_deg,el_deg,d_el_deg\n1,2,3\n")
    night = read(path)
    broken = night.at.columns | {"note": np.array([1, 2, 3])}

    with pytest.raises(ValueError, match="argument"):
        write(
            Recordings(
                Circumstances(night.at.az, night.at.el, None, broken),
                night.x,
                night.y,
                night.sigma_x,
                night.sigma_y,
                night.line,
                path,
            ),
            path,
        )

    assert path.read_text() == "az_deg,el_deg,d_el_deg\n1,2,3\n"


def test_ecsv_units_beside_the_names(tmp_path):
    """An ECSV column may carry its unit as such; a contradiction is refused."""
    from astropy import units
    from astropy.table import QTable

    path = tmp_path / "night.ecsv"
    table = QTable({"az": [10] * units.deg, "el": [40] * units.deg, "d_el": [5] * units.arcsec})
    table.write(path)

    night = read(path)

    assert night.y == pytest.approx(np.radians([5 / 3600]))
    table["d_el_deg"] = [5] * units.arcsec
    table.remove_column("d_el")
    table.write(path, overwrite=True)
    with pytest.raises(ValueError, match="expected 'deg'"):
        read(path)


def test_ecsv_holds_times_of_astropy(tmp_path):
    """A time is read in UTC, a masked one as blank; a difference of times is none."""
    from astropy import units
    from astropy.table import QTable
    from astropy.time import Time, TimeDelta

    path, when = tmp_path / "night.ecsv", Time("2025-11-03T04:00:00") + [0, 1, 2] * units.hour
    masked = when.copy()
    masked[1] = np.ma.masked
    plain = {"az": [10, 130, 250] * units.deg, "el": [40, 50, 60] * units.deg}
    plain["d_el"] = [5, 6, 7] * units.arcsec
    for name, times in {"time_utc": when, "time": when.tai, "blank": masked}.items():
        QTable(plain | {name.replace("blank", "time_utc"): times}).write(path, overwrite=True)
        found = read(path).at.column("time")

        assert found[[0, 2]] == pytest.approx(when.unix[[0, 2]], abs=1e-3)
        assert np.isfinite(found[1]) == (name != "blank")
    QTable(plain | {"took": TimeDelta([9, 8, 9] * units.s)}).write(path, overwrite=True)

    assert read(path).y == pytest.approx(np.radians(np.array([5, 6, 7]) / 3600))


def with_unit(path, name, unit, number):
    """Write an ECSV file with one row and one column more, and return it."""
    path.write_text(
        "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: az_deg, datatype: float64}\n"
        "# - {name: el_deg, datatype: float64}\n"
        "# - {name: d_el, unit: arcsec, datatype: float64}\n"
        f"# - {{name: {name}, unit: {unit}, datatype: float64}}\n"
        f"az_deg el_deg d_el {name}\n10 40 5 {number!r}\n"
    )
    return path


@pytest.mark.parametrize(
    ("name", "unit", "number", "column", "held"),
    [
        ("temperature_c", "K", 285.15, "temperature_c", 12.0),
        ("temperature", "K", 285.15, "temperature_c", 12.0),
        ("temperature_c", "deg_C", 12.0, "temperature_c", 12.0),
        ("pressure_hpa", "kPa", 80.2, "pressure_hpa", 802.0),
        ("tsys_k", "K", 12.0, "tsys_k", 12.0),
    ],
)
def test_ecsv_units_are_converted_to_those_of_the_names(tmp_path, name, unit, number, column, held):
    """Kelvins are no degrees; what the contract does not know stays as it is."""
    night = read(with_unit(tmp_path / "night.ecsv", name, unit, number))

    assert night.at.column(column) == pytest.approx([held])


@pytest.mark.parametrize(
    ("name", "unit", "wrong"),
    [
        ("temperature_c", "kg", "column 'temperature_c' is in kg, expected deg_C"),
        ("d_az", "furlong", "column 'd_az_deg' is in furlong, expected deg"),
    ],
)
def test_an_ecsv_unit_that_the_name_cannot_have_is_refused(tmp_path, name, unit, wrong):
    """In one line that says both."""
    with pytest.raises(ValueError, match=wrong):
        read(with_unit(tmp_path / "night.ecsv", name, unit, 1.0))


@pytest.mark.parametrize(
    ("of", "cell", "reason"),
    [
        ("unit: K, datatype: string", "warm", "holds text, expected numbers in K"),
        ("datatype: string, subtype: 'float64[null]'", "[1.0]", r"temperature_c is '\[1.\]'"),
        ("datatype: string, subtype: 'float64[2]'", "[1.0,2.0]", r"is '\[1.0, 2.0\]'"),
    ],
)
def test_ecsv_cells_that_are_no_numbers_are_refused(tmp_path, of, cell, reason):
    """Text in a column with a unit, and lists, in one line with the file's name."""
    path = tmp_path / "night.ecsv"
    names = ("az_deg", "el_deg", "d_el_deg")
    plain = "".join(f"# - {{name: {name}, datatype: float64}}\n" for name in names)
    head = f"# %ECSV 1.0\n# ---\n# datatype:\n{plain}# - {{name: temperature_c, {of}}}\n"
    header = " ".join([*names, "temperature_c"])
    path.write_text(f"{head}# schema: astropy-2.0\n{header}\n1 20 0.1 {cell}\n")

    with pytest.raises(BadInput, match=reason):
        read(path)

"""Recordings of any mount: which one the columns tell, its names of offsets, its way on the sky."""

import dataclasses

import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.errors import BadInput
from pyport.formats.convert import convert
from pyport.mounts import KINDS
from pyport.recordings import read, write
from pyport.recordings.naming import column, names

LATITUDE = "# latitude_deg: 53.1\n"
GERMAN = "ha_deg,dec_deg,d_ha_arcsec,d_dec_arcsec,pier_side\n-20,60,10,5,east\n30,-5,8,-3,west\n"


def written(tmp_path, text, name="night.csv"):
    """Return a file with a text."""
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("text", "mount"),
    [
        (f"{LATITUDE}{GERMAN}", "german"),
        (f"{LATITUDE}ha_h,dec_deg,d_xha_arcsec,d_dec_arcsec\n1,60,10,5\n", "equatorial"),
        (f"{LATITUDE}# mount: fork\nhour_angle_h,dec_deg,d_ha_arcsec\n1,60,10\n", "fork"),
        ("# mount: xy-ns\nx_deg,y_deg,d_x_arcsec,d_y_arcsec\n10,-20,3,4\n", "xy-ns"),
        ("# mount: xyew, secondary\nx_deg,y_deg,d_xx_arcsec\n10,-20,3\n", "xy-ew"),
        ("az_deg,el_deg,d_xel_arcsec\n10,20,3\n", "altaz"),
        (
            f"{LATITUDE}# mount: equatorial\naz_deg,el_deg,d_xel_arcsec,d_el_arcsec\n10,20,3,4\n",
            "equatorial",
        ),
    ],
)
def test_which_mount(tmp_path, text, mount):
    """A header says it, by our word or another program's; where it is silent the columns do."""
    recordings = read(written(tmp_path, text))

    assert recordings.at.mount is KINDS[mount]
    assert mount == "altaz" or mount in recordings.meta["mount"]


def test_coordinates_and_places(tmp_path):
    """Hour angle and declination give the place; a coordinate's offset is one on the sky."""
    recordings = read(written(tmp_path, LATITUDE + GERMAN))
    first, second = recordings.at.mount.angles(recordings.at.az, recordings.at.el, 53.1 * DEG)

    assert np.allclose(first / DEG, [-20, 30], atol=1e-12)
    assert np.allclose(second / DEG, [60, -5], atol=1e-12)
    assert np.allclose(recordings.x / ARCSEC, [10 * np.cos(60 * DEG), 8 * np.cos(5 * DEG)])
    assert np.allclose(column(recordings, "d_ha_arcsec"), [10, 8])
    assert np.allclose(recordings.y / ARCSEC, [5, -3])
    assert {"d_xha_deg", "d_dec_deg", "sigma_xha_deg"} <= set(names(recordings))


@pytest.mark.parametrize("words", ["east west", "E W", "pierEast pierWest", "EAST West"])
def test_sides_of_a_pier_by_other_names(tmp_path, words):
    """E and W, and what ASCOM says, are east and west, for the reader and for TPOINT's file."""
    east, west = words.split()
    table = written(tmp_path, LATITUDE + GERMAN.replace("east", east).replace("west", west))
    recordings = read(table)
    convert(str(table), tmp_path / "night.dat")

    assert recordings.at.column("pier_side").tolist() == ["east", "west"]
    assert read(tmp_path / "night.dat").at.column("pier_side").tolist() == ["east", "west"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (GERMAN.replace("-20,60", "160,20"), "csv:3: .* of a place below the horizon"),
        (GERMAN.replace("west", "up"), "csv:4: pier_side is not east, west or blank"),
    ],
)
def test_what_no_telescope_sees_is_refused(tmp_path, text, words):
    """An hour angle of another sign or unit, and a side that is none, at their line."""
    with pytest.raises(BadInput, match=words):
        read(written(tmp_path, LATITUDE + text))


@pytest.mark.parametrize("suffix", ["csv", "parquet", "ecsv"])
def test_written_and_read_again(tmp_path, suffix):
    """What was read is written under the mount's names, and read again as it was."""
    first = read(written(tmp_path, LATITUDE + GERMAN))
    write(first, tmp_path / f"again.{suffix}")
    again = read(tmp_path / f"again.{suffix}")

    assert again.at.mount is first.at.mount
    for name in ("x", "y"):
        assert np.allclose(getattr(again, name), getattr(first, name), rtol=0, atol=1e-15)
    assert np.allclose(again.at.axes.az, first.at.axes.az, rtol=0, atol=1e-12)


def test_offsets_on_the_sky_come_through_the_mount(tmp_path):
    """Measured across and along elevation they are turned into the mount's axes, no length lost."""
    text = "az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n100,40,3,4\n-30,70,-5,12\n"
    flat = read(written(tmp_path, LATITUDE + text))
    polar = read(written(tmp_path, f"# mount: equatorial\n{LATITUDE}{text}", "polar.csv"))
    turned = dataclasses.replace(flat.at, mount=KINDS["equatorial"]).along_axes(flat.x, flat.y)

    assert np.allclose(np.hypot(polar.x, polar.y) / ARCSEC, [5, 13])
    assert np.allclose([polar.x, polar.y], turned)


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        (GERMAN, "a German equatorial mount needs a line '# latitude_deg"),
        (f"{LATITUDE}# mount: german\nha_deg,dec_deg,d_ha_deg\n1,2,0.1\n", "a column pier_side"),
        (f"{LATITUDE}{GERMAN.replace('west', 'up')}", "pier_side is not east, west or blank"),
        (f"{LATITUDE}{GERMAN.replace('-5,8', '95,8')}", "declination outside"),
        ("x_deg,y_deg,d_x_arcsec\n1,2,3\n", "'# mount: xy-ns' or '# mount: xy-ew'"),
        ("# mount: xy-ns, german\nx_deg,y_deg,d_x_arcsec\n1,2,3\n", "xy-ns and german, expected"),
        ("# mount: horse\naz_deg,el_deg,d_az_deg\n1,2,0.1\n", "mount is 'horse', expected one"),
        ("# mount: xy-ns\nx_deg,y_deg,d_ha_deg\n1,2,0.1\n", "d_ha is no offset of an X-Y mount"),
        ("# mount: xy-ns\nha_deg,dec_deg,d_x_deg,d_y_deg\n1,2,0.1,0.1\n", "x_deg and y_deg"),
        (f"{LATITUDE}# mount: fork\naz_deg,el_deg,d_el_deg\n1,2,0.1\n", "one of two offsets"),
        (f"{LATITUDE}ha_deg,dec_deg,d_ha_deg,d_xha_deg\n1,2,0.1,0.1\n", "say the same"),
    ],
)
def test_what_is_refused(tmp_path, text, wrong):
    """What cannot be meant is refused with what was expected."""
    with pytest.raises(BadInput, match=wrong):
        read(written(tmp_path, text))


def test_rows_without_a_side_are_excluded(tmp_path):
    """Where a mount turns over, a row that does not say on which side it was is of no use."""
    recordings = read(written(tmp_path, f"{LATITUDE}{GERMAN}5,6,1,1,\n"))

    assert len(recordings) == 2
    assert [one.reason for one in recordings.set_aside] == ["no side of the pier"]

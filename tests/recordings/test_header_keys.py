"""Header keys that are spelled otherwise are understood, refused or noted, never ignored."""

import numpy as np
import pytest

import pyport
from pyport.errors import BadInput
from pyport.recordings import read
from pyport.recordings.raw import FileOptions

ROWS = "10,40,1,2\n100,50,2,3\n200,60,3,1\n300,70,1,1\n"
NAMES = "az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n"


def written(tmp_path, *header: str, below: str = "", suffix: str = ".csv") -> str:
    """Write recordings under some lines of a header."""
    file = tmp_path / f"night{suffix}"
    file.write_text("".join(f"{one}\n" for one in header) + NAMES + ROWS + below)
    return str(file)


@pytest.mark.parametrize(
    "line",
    [
        "# azimuth zero: south",
        "# azimuth-zero: south",
        "# azimuth_zero = south",
        "#azimuth zero=south",
    ],
)
def test_blanks_hyphens_and_equals_signs_are_understood(tmp_path, line):
    """The azimuths count from south."""
    found = read(written(tmp_path, line))

    assert np.degrees(found.at.az[0]) == pytest.approx(190)
    assert found.notes == ()


def test_a_key_below_the_names_is_one_too(tmp_path):
    """Whatever has been read below it; two that contradict each other are refused."""
    below = "# azimuth_zero: south\n# seen: clouds\n"
    assert np.degrees(read(written(tmp_path, below=below)).at.az[0]) == pytest.approx(190)

    with pytest.raises(
        BadInput, match=r"7: azimuth_zero is 'south', expected 'north' as in line 1"
    ):
        read(written(tmp_path, "# azimuth_zero: north", below=below))
    with pytest.raises(BadInput, match=r"2: latitude_deg is '35', expected '53' as in line 1"):
        read(written(tmp_path, "# latitude_deg: 53", "# latitude_deg: 35"))
    read(
        written(
            tmp_path, "# latitude_deg: 53", "# telescope: A", "# telescope: B", "# latitude_deg: 53"
        )
    )


def test_another_word_for_a_key_is_refused_with_the_right_one(tmp_path):
    """With blanks as with underscores."""
    for line in ("# azimuth from: south", "# azimuth_from: south", "# azimuth from = south"):
        with pytest.raises(BadInput, match="'azimuth_from' is no key, did you mean 'azimuth_zero'"):
            read(written(tmp_path, line))


@pytest.mark.parametrize(
    ("line", "key", "right"),
    [
        ("# azimut_zero: south", "azimut_zero", "azimuth_zero"),
        ("# azimuth reference: from south through west", "azimuth_reference", "azimuth_zero"),
        ("# Lattitude deg: 53.1", "Lattitude_deg", "latitude_deg"),
        ("# site longitude: 18.6", "site_longitude", "longitude_deg"),
        ("# largest offset: 20", "largest_offset", "largest_offset_deg"),
        ("# latitude south: 30.2", "latitude_south", "latitude_deg"),
    ],
)
def test_a_slip_is_noted(tmp_path, line, key, right):
    """With its line and the key that may be meant; the file is read all the same."""
    (note,) = read(written(tmp_path, "# of tonight", line)).notes

    assert note == (
        f"header key {key!r} in line 2 is not known and not used: {right!r} may be meant"
    )


@pytest.mark.parametrize(
    "line",
    [
        "# observer: J. Smith",
        "# altitude: 2400 m",
        "# elevation limit: 15",
        "# azimuth error: 3 arcsec",
        "# azimuth: from north",
        "# weather = fair: no wind",
        "# we went south at 3: clouds",
        "# the amplitude of the latitude variation is small: see logbook",
        "# telescope name: RT32",
        "# amount: 3",
    ],
)
def test_comments_are_no_noise(tmp_path, line):
    """Nothing is said of what is like no key."""
    assert read(written(tmp_path, line)).notes == ()


def test_slips_of_options_are_refused(tmp_path):
    """There nothing else can be meant."""
    file = written(tmp_path)
    with pytest.raises(BadInput, match="--set 'lattitude_deg' is no key, did you mean 'latitude"):
        read(file, FileOptions({"lattitude_deg": "53"}))
    with pytest.raises(BadInput, match="header 'azimut_zero' is no key, did you mean 'azimuth_z"):
        pyport.fit(file, header={"azimut_zero": "south"})


def test_keys_of_typed_tables(tmp_path):
    """Blanks in them are understood as well."""
    from astropy.table import Table

    columns = np.array([[10, 40, 1, 2], [100, 50, 2, 3.0]]).T
    table = Table(list(columns), names=NAMES.strip().split(","))
    table.meta = {"azimuth zero": "south", "site longitude": "18"}
    table.write(tmp_path / "night.ecsv")

    found = read(tmp_path / "night.ecsv")

    assert np.degrees(found.at.az[0]) == pytest.approx(190)
    assert len(found.notes) == 1

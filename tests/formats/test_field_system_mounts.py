"""The Field System on mounts whose first axis leans: its functions, files and fits."""

import erfa
import numpy as np
import pytest
from mounts.steel import angles, offsets, steel

import pyport
from pyport.angles import ARCSEC, DEG
from pyport.effects import Circumstances, Site
from pyport.errors import BadInput
from pyport.formats import models
from pyport.formats.convert import convert
from pyport.models.terms import field_system
from pyport.mounts import KINDS
from pyport.recordings.formats.xtr import AXES
from pyport.recordings.raw import FileOptions

PHI = -25.9 * DEG
#: The axes other than azimuth and elevation, and how their first one leans.
LEANING = {"hadc": PHI, "xyns": 0.0, "xyew": 0.0}


def functions(x, y, phi):
    """Return what a unit of each parameter adds to both angles, as the documentation prints it."""
    none, one = np.zeros_like(x), np.ones_like(x)
    return {
        "P1": (one, none),
        "P2": (-np.cos(phi) * np.sin(x) / np.cos(y), none),
        "P3": (np.tan(y), none),
        "P4": (-1 / np.cos(y), none),
        "P5": (np.sin(x) * np.tan(y), np.cos(x)),
        "P6": (-np.cos(x) * np.tan(y), np.sin(x)),
        "P7": (none, one),
        "P8": (none, np.sin(phi) * np.cos(y) - np.cos(phi) * np.sin(y) * np.cos(x)),
        "P9": (none, y),
        "P10": (none, np.cos(y)),
        "P11": (none, np.sin(y)),
        "P12": (x, none),
        "P13": (np.cos(x), none),
        "P14": (np.sin(x), none),
        "P15": (none, np.cos(2 * x)),
        "P16": (none, np.sin(2 * x)),
        "P17": (np.cos(2 * x), none),
        "P18": (np.sin(2 * x), none),
        "P19": (none, np.cos(8 * y)),
        "P20": (none, np.sin(8 * y)),
        "P21": (none, np.cos(x)),
        "P22": (none, np.sin(x)),
    }


def sky(n=150, seed=6):
    """Return azimuths and elevations well above the ground."""
    rng = np.random.default_rng(seed)
    return rng.uniform(0, 2 * np.pi, n), rng.uniform(30, 80, n) * DEG


@pytest.mark.parametrize("word", LEANING)
def test_terms_are_functions_of_the_two_angles(word):
    """Each is the Field System's function of hour angle and declination, or X and Y, to 1e-12."""
    kind, (az, el) = AXES[word], sky()
    x, y = angles(
        steel(kind, PHI),
        np.stack([np.cos(el) * np.sin(az), np.cos(el) * np.cos(az), np.sin(el)], axis=1),
    )
    at = Circumstances(az, el, Site(PHI), mount=KINDS[kind])

    for name, (dx, dy) in functions(x, y, LEANING[word]).items():
        effect = field_system.word(name, LEANING[word] / DEG).effect()
        across, along = effect.columns(at)
        np.testing.assert_allclose(across[:, 0], dx * np.cos(y), atol=1e-12, err_msg=name)
        np.testing.assert_allclose(along[:, 0], dy, atol=1e-12, err_msg=name)
    assert field_system.word("P23", 0.0).effect().mounts == ("altaz",)


def test_hour_angle_and_declination_are_those_of_erfa():
    """And X and Y north and south are those of the Field System: east and up, and north."""
    az, el = sky()
    at = Circumstances(az, el, Site(PHI))
    hour_angle, dec = KINDS["equatorial"].angles(az, el, PHI)
    x, y = KINDS["xy-ns"].angles(at.az, at.el)

    np.testing.assert_allclose([hour_angle, dec], erfa.ae2hd(az, el, PHI), atol=1e-12)
    np.testing.assert_allclose(x, np.arctan2(np.cos(el) * np.sin(az), np.sin(el)), atol=1e-12)
    np.testing.assert_allclose(y, np.arcsin(np.cos(el) * np.cos(az)), atol=1e-12)


#: Coefficients [arcsec], and the same as flaws of steel.
TRUTH = {"P1": 90, "P2": 25, "P3": -35, "P4": 60, "P5": -40, "P6": 70, "P7": -80, "P8": 25}
FLAWS = {
    "read": lambda a, d: (90 * ARCSEC + 0 * a, -80 * ARCSEC + 0 * d),
    "skew": -35 * ARCSEC,
    "collimation": -60 * ARCSEC,
    "lean": (-40 * ARCSEC, 70 * ARCSEC),
    "droop": 25 * ARCSEC,
}


def extracted(word, path):
    """Write what the Field System extracts from a mount of rotations with those flaws."""
    kind, (az, el) = AXES[word], sky()
    across, along = offsets(steel(kind, PHI), az, el, FLAWS)
    x, y = KINDS[kind].angles(az, el, PHI)
    lines = [
        f" 1 {one[0]:.7f} {one[1]:.7f} {one[2]:.8f} {one[3]:.8f} 0.0010000 0.0010000"
        for one in np.degrees([x, y, across / np.cos(y), along]).T
    ]
    path.write_text("\n".join(["$antenna", f" DISH {word} 1", "$data", *lines, "$stats", ""]))


def control(path, phi):
    """Write a mdlpo.ctl that fits P1 to P8."""
    flags, zeros = "1 " * 8 + "0 " * 22, "0.0 " * 30
    path.write_text(f"1 2024 60 0 0 0\n{phi / DEG:.4f} {flags}\n{zeros}\n")


@pytest.mark.parametrize("word", LEANING)
def test_a_session_gives_back_its_parameters(tmp_path, word):
    """Read, fitted with P1 to P8, written as a mdlpo.ctl and as an xtr, and both again."""
    data, old, new = (tmp_path / name for name in ("x.xtr", "old.ctl", "new.ctl"))
    extracted(word, data)
    control(old, LEANING[word])
    header = {"latitude_deg": PHI / DEG}

    fit = pyport.fit(str(data), str(old), header=header)
    fit.save(new)
    again = pyport.fit(str(data), str(new), header=header)
    convert(
        str(data), tmp_path / "twice.xtr", given=FileOptions(keys={"latitude_deg": str(PHI / DEG)})
    )
    written = models.read(new)

    for name, value in TRUTH.items():
        assert fit.coefficients[name].value * 3600 == pytest.approx(value, abs=0.2)
        assert again.coefficients[name].value == pytest.approx(fit.coefficients[name].value)
    assert float(written.phi_deg) == pytest.approx(LEANING[word] / DEG)
    assert (tmp_path / "twice.xtr").read_text().split() == data.read_text().split()


@pytest.mark.parametrize("word", LEANING)
def test_classical_terms_have_its_names(tmp_path, word):
    """A fit in pyport's terms becomes P1 P3 P4 P5 P6 P7, and gravity P2 and P8 of one size."""
    data, new = tmp_path / "x.xtr", tmp_path / "new.ctl"
    extracted(word, data)
    fit = pyport.fit(str(data), header={"latitude_deg": PHI / DEG})
    fit.save(new)
    found = {one.name: float(one.value) * 3600 for one in models.read(new).entries if one.used}

    assert found == pytest.approx({**TRUTH}, abs=0.2)
    assert found["P2"] == found["P8"]
    at = Circumstances(*sky(), Site(PHI), mount=KINDS[AXES[word]])
    both = (models.load(str(new)).on(at.mount), fit.model.model)
    written, fitted = (np.stack(one.offsets(at)) / ARCSEC for one in both)
    np.testing.assert_allclose(written, fitted, atol=1e-5)


def test_a_model_that_stands_upright_is_none_of_a_leaning_mount(tmp_path):
    """An angle phi of 90 deg is an azimuth's; a German mount has no place in either file."""
    data, old = tmp_path / "x.xtr", tmp_path / "old.ctl"
    extracted("hadc", data)
    control(old, np.pi / 2)
    header = {"latitude_deg": PHI / DEG}

    with pytest.raises(BadInput, match="none of an equatorial mount"):
        pyport.fit(str(data), str(old), header=header)
    with pytest.raises(BadInput, match="latitude"):
        pyport.fit(str(data))
    german = {"ha_deg": [1.0], "dec_deg": [2.0], "d_ha_deg": [0.1], "d_dec_deg": [0.1]}
    night = tmp_path / "night.csv"
    night.write_text(
        "# mount: german\n# latitude_deg: 40\n"
        + ",".join([*german, "pier_side"])
        + "\n1,2,0.1,0.1,west\n"
    )
    with pytest.raises(BadInput, match="no axes of a German equatorial mount"):
        convert(str(night), tmp_path / "night.xtr")

"""From the finding to the mount: diagnose --save, compare, convert, for one cause of each kind."""

import shutil

import numpy as np
import pytest
from click.testing import CliRunner
from diagnosis.made import recordings
from samples import sample

from pyport import pipeline as run
from pyport.angles import ARCSEC, DEG
from pyport.cli import pyport
from pyport.diagnosis.diagnose import diagnose
from pyport.errors import BadInput
from pyport.formats.models import load
from pyport.models import toml
from pyport.recordings import read, write
from pyport.report.finding import completed

TERMS = {"IA": 30, "IE": 12, "CA": -20, "NPAE": 25, "AN": 8, "AW": 1, "TF": 50}
OLD = "\n".join(["old", "T 1 1 0 0", *(f"  {name} {n}.0" for name, n in TERMS.items()), "END\n"])
#: How closely the saved model's offsets repeat what was found.
PROMISED = 1e-9 * DEG


def far(at, centre_deg):
    """Return how far azimuths are from a centre [rad]."""
    return (at.az - np.radians(centre_deg) + np.pi) % (2 * np.pi) - np.pi


#: What a grid of directions has to be given beside them.
FOR_A_GRID = {
    "temperature": ("--set", "temperature_c=8"),
    "epoch_offset": ("--set", "time_utc=2008-03-01T00:00:00"),
}
#: What happened, and what TPOINT lacks a name for.
CAUSES = {
    "refraction": ({"y": lambda at: 30 / np.tan(at.el)}, ""),
    "temperature": ({"y": lambda at: 1.5 * (at.columns["temperature_c"] - 8)}, "temperature"),
    "subreflector_jump": (
        {"y": lambda at: 25.0 * (at.el > np.radians(55 + 10 * np.cos(at.az)))},
        "jump",
    ),
    "azimuth_track": (
        {
            "x": lambda at: 12 * np.sin(at.el) * np.sin(3 * at.az),
            "y": lambda at: 14 * np.cos(3 * at.az),
        },
        "",
    ),
    "epoch_offset": (
        {
            "y": lambda at: 15.0 * (at.columns["time"] > 1.2e9 + 86400 * 9),
            "time": 1.2e9 + np.sort(np.random.default_rng(3).uniform(0, 20 * 86400, 900)),
            "session": np.full(900, "s"),
        },
        "offset_xel[since",
    ),
    "unknown": ({"y": lambda at: 20 * np.exp(-0.5 * (far(at, 200) / np.radians(20)) ** 2)}, ""),
    "unknown, over the sky": (
        {"y": lambda at: 9 * np.exp(np.sin(2 * at.az) * np.sin(3 * at.el))},
        "",
    ),
}


def does(*words):
    """Return what a command prints, and its error if it has one."""
    done = CliRunner().invoke(pyport, [str(word) for word in words])
    assert done.exception is None or isinstance(done.exception, BadInput), done.output
    return done.output, str(done.exception or "")


def watched(monkeypatch):
    """Return a list that the diagnoses of a command are put into."""
    done = []

    def kept(*given, **more):
        done.append(diagnose(*given, **more))
        return done[-1]

    monkeypatch.setattr(run, "diagnose", kept)
    return done


@pytest.mark.slow
@pytest.mark.parametrize("cause", CAUSES)
def test_a_finding_is_carried_to_the_mount(cause, tmp_path, monkeypatch):
    """New minus old at the recordings is before minus after; then compare; then the other program.

    What TPOINT has no name for is refused by name, and taken beside the file as a grid.
    """
    shape, nameless = CAUSES[cause]
    done = watched(monkeypatch)
    night, old, new = (tmp_path / name for name in ("night.csv", "old.mod", "new.toml"))
    write(recordings(900, 5, **shape), night)
    old.write_text(OLD)
    told, _ = does("diagnose", night, "--model", old, "--save", new)
    (found,) = done
    at, before, after = read(night).at, load(str(old)), load(str(new))
    moved = np.subtract(after.offsets(at), before.offsets(at))

    assert found.findings[0].effect == cause.partition(",")[0]
    assert "enter this into the control system" in told
    assert "change against the file" in told
    np.testing.assert_allclose(
        found.problem.stack.spread(*moved),
        found.problem.residual - found.left(found.after),
        atol=PROMISED,
        rtol=0,
    )
    assert after.completed.values == completed(found).completed.values

    told, refused = does("compare", old, new, "--recordings", night)
    was, now = told.split("recordings, sky: rms ")[1].split(" arcsec")[0].split(" -> ")
    assert not refused
    assert float(now) < float(was)

    target, grid = tmp_path / "new.mod", tmp_path / "grid.csv"
    told, refused = does("convert", new, target)
    if nameless:
        assert "tpoint has no name for" in refused
        assert nameless in refused
        told, refused = does("convert", new, target, "--rest-as", grid, *FOR_A_GRID.get(cause, ()))
        assert "arcsec rms over the sky" in told
    missed = np.subtract(load(str(target)).offsets(at), after.offsets(at))
    assert not refused
    if found.findings[0].effect == "unknown":
        assert "what has no name as" in told
        assert np.sqrt(np.mean((missed**2).sum(axis=0))) < 3 * ARCSEC
    elif not nameless:
        np.testing.assert_allclose(missed, 0, atol=1e-3 * ARCSEC)


def test_a_real_night_is_carried_to_tpoint(tmp_path, monkeypatch):
    """AuxTel's 54 stars and the model in force: no option is asked for; TPOINT's file has the gain.

    It takes the seconds that a diagnosis of real stars takes.
    """
    done = watched(monkeypatch)
    night, old, new, target = (
        tmp_path / name for name in ("night.dat", "old.mod", "new.toml", "new.mod")
    )
    shutil.copy(sample("auxtel/AT_point_data_20220406_tw004_corr.dat"), night)
    shutil.copy(sample("auxtel/at_20220406_ia_ie_an_aw_tx10_ca.mod"), old)
    told = [
        does("diagnose", night, "--model", old, "--save", new),
        does("compare", old, new, "--recordings", night),
        does("convert", new, target),
    ]
    (found,) = done
    at = read(night).at
    before, after, held = (load(str(path)).offsets(at) for path in (old, new, target))

    assert [refused for _, refused in told] == ["", "", ""]
    np.testing.assert_allclose(
        found.problem.stack.spread(*np.subtract(after, before)),
        found.problem.residual - found.left(found.after),
        atol=PROMISED,
        rtol=0,
    )
    text, _ = does("compare", old, target, "--recordings", night)
    was, now = text.split("recordings, sky: rms ")[1].split(" arcsec")[0].split(" -> ")
    assert was == "3.14"
    assert float(now) < 2.6
    assert np.sqrt(np.mean(np.square(np.subtract(held, after)).sum(axis=0))) < 0.7 * ARCSEC


@pytest.mark.slow
def test_nothing_is_left_of_what_was_carried(tmp_path):
    """A fresh start from the saved model, held, finds nothing more."""
    measured = recordings(900, 5, **CAUSES["subreflector_jump"][0])
    new = tmp_path / "new.toml"
    toml.write(completed(diagnose(measured, load("altaz"))), new)

    assert not diagnose(measured, load(str(new)), refit=()).mismatch

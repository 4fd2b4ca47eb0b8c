"""What recordings show comes first; what it means is claimed for the mount that was declared."""

from __future__ import annotations

import re

import numpy as np
import pytest
from click.testing import CliRunner

from pyport.cli import pyport
from pyport.diagnosis.naming.finding import Parameter, Where
from pyport.diagnosis.naming.words import sentence
from pyport.effects import CATALOGUE
from pyport.effects.mounts import MOUNTS, declared, meaning, times
from pyport.effects.telescope.encoders import azimuth_harmonics
from pyport.effects.telescope.track import azimuth_track
from pyport.errors import BadInput
from pyport.recordings import read

#: What only some telescopes have: no effect may claim it on whatever mount.
_FITTINGS = re.compile(r"\b(rail|track|box|boxes|wrap|platform|camera|secondary|subreflector)\b")


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda one: one.id)
def test_no_effect_claims_what_nobody_declared(effect):
    """Neither pattern nor sentence names a part of some mounts; what it means there is a field."""
    assert not _FITTINGS.search(effect.sentence)
    assert not _FITTINGS.search(effect.pattern)
    assert set(effect.means) <= set(MOUNTS)
    assert effect.pattern or not effect.physical
    assert not effect.pattern.endswith(".")


@pytest.mark.parametrize(
    ("mounts", "said", "unsaid"),
    [
        ((), "on a wheel-and-track mount it may be the track", "on a wheel-and-track mount: the"),
        (("wheel-and-track",), "on a wheel-and-track mount: the track", "bearing"),
        (("bearing",), "on a mount on an azimuth bearing: the azimuth bearing", "track"),
        (("nasmyth",), "the mount rocks as it turns in azimuth", "track"),
    ],
)
def test_the_meaning_follows_the_mount(mounts, said, unsaid):
    """Declared: what it is there. Not declared: what it may be. Another mount: nothing more."""
    told = meaning(azimuth_track(2), mounts)

    assert said in told
    assert unsaid not in told


def test_what_the_columns_show_comes_first():
    """Pattern, axes, size, cause."""
    size = Parameter("track_pitch_sine", 4.2, 0.3, "arcsec")
    told = sentence(azimuth_track(2), [size], Where(("xel", "el")), None, ("wheel-and-track",))

    assert told.startswith("twice per turn of azimuth, in both axes")
    assert told.index("4.20 +- 0.30 arcsec") < told.index("on a wheel-and-track mount: the track")


def test_of_many_coefficients_those_far_from_zero_are_named():
    """The antenna that has the fault stands in the sentence, wherever it stands in the list."""
    sizes = [Parameter(f"track_pitch_sine[a{n}]", 0.1 * n, 1.0, "arcsec") for n in range(9)]
    sizes[7] = Parameter("track_pitch_sine[a7]", -31.0, 1.2, "arcsec")
    sizes[8] = Parameter("track_pitch_sine[a8]", 40.0, 25.0, "arcsec")
    said = sentence(azimuth_track(2), sizes, Where(("xel", "el")))

    first = said.partition("(seen in")[2].partition(", ")[2]
    assert first.startswith("track pitch sine[a7] -31.0 +- 1.2 arcsec, track pitch sine[a8]")
    assert "and 3 more" in said
    assert "[a0]" not in said


@pytest.mark.parametrize(("k", "said"), [(2, "twice"), (3, "three times"), (8, "8 times")])
def test_harmonics_are_counted_in_words(k, said):
    """So many times per turn."""
    assert times(k) == said
    assert azimuth_harmonics(k).pattern.startswith(f"{said} per turn of azimuth")


def written(path, header=""):
    """Write twenty pointings with a header line."""
    rng = np.random.default_rng(1)
    rows = [
        f"{az:.3f},{el:.3f},{x:.4f},{y:.4f}"
        for az, el, x, y in zip(
            rng.uniform(0, 360, 20),
            rng.uniform(20, 80, 20),
            *rng.normal(0, 1e-3, (2, 20)),
            strict=True,
        )
    ]
    path.write_text("\n".join([f"{header}az_deg,el_deg,d_xel_deg,d_el_deg", *rows, ""]))
    return path


def test_a_mount_is_declared_in_the_file_or_on_the_line(tmp_path):
    """`# mount:` and `--mount` are one; a word that nothing knows is refused with those known."""
    file = written(tmp_path / "a.csv", "# mount: Wheel-and-track, nasmyth\n")

    assert declared(read(file).meta) == ("wheel-and-track", "nasmyth")
    with pytest.raises(
        BadInput, match=r"mount is 'trolley', expected one or more of altaz, .*wheel-and"
    ):
        read(written(tmp_path / "b.csv", "# mount: trolley\n"))
    plain = written(tmp_path / "c.csv")
    refused = CliRunner().invoke(
        pyport, ["fit", str(plain), "--model", "altaz", "--mount", "trolley"]
    )
    assert "mount is 'trolley'" in refused.output + str(refused.exception)
    done = CliRunner().invoke(pyport, ["fit", str(plain), "--model", "altaz", "--mount", "bearing"])
    assert done.exit_code == 0

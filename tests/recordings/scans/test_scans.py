"""Scans simulated here, with known offsets, come back as these offsets."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from click.testing import CliRunner

from pyport.angles import ARCMIN
from pyport.cli.files import offsets
from pyport.errors import BadInput
from pyport.recordings import read
from pyport.recordings.scans import Average, averages, fit_peak, measure, offset_along_scan, text

RATE = 20.0
BEAM_ARCMIN = 24.0
EXPECTED = np.datetime64("2003-06-01T18:40:00", "ms")


def simulated_power(t_s, peak_s, rng, noise=0.02, height=1.0):
    """Return power against time of a beam on a sloping baseline (simulated)."""
    width_s = BEAM_ARCMIN / RATE * 60
    bell = height * np.exp(-4 * np.log(2) * ((t_s - peak_s) / width_s) ** 2)
    return 5 + 0.0004 * t_s + bell + rng.normal(0, noise, len(t_s))


def write_scans(path, truths, rng, noise=0.02, **extra):
    """Write simulated scans: (antenna, axis, round, offset, half difference) [arcmin] each."""
    t_s = np.arange(-150.0, 150.0, 2.0)
    scan = 0
    with path.open("w", newline="") as file:
        file.write("# latitude_deg: 19.0965\n# made: simulated\n")
        writer = csv.writer(file)
        names = "session scan antenna channel time_utc power expected_utc scan_axis scan_direction"
        writer.writerow(
            [*names.split(), "scan_rate_arcmin_per_min", "round", "az_deg", "el_deg", *extra]
        )
        for antenna, axis, turn, offset, half in truths:
            for direction in (1, -1, 1, -1):
                scan += 1
                along = offset + direction * half
                peak_s = direction * along / RATE * 60
                for channel in (130, 175):
                    power = simulated_power(t_s, peak_s, rng, noise)
                    for when, level in zip(t_s, power, strict=True):
                        stamp = EXPECTED + np.timedelta64(int(when * 1000), "ms")
                        head = ["a", scan, antenna, channel, stamp, level, EXPECTED]
                        row = [*head, axis, direction, RATE, turn, 52.75, 60, *extra.values()]
                        writer.writerow(row)
    return path


def test_peak():
    """The peak's time comes back within its sigma, its width and height too."""
    rng = np.random.default_rng(1)
    t_s = np.arange(-150.0, 150.0, 2.0)

    peak = fit_peak(t_s, simulated_power(t_s, 13.7, rng))

    assert peak.time_s == pytest.approx(13.7, abs=4 * peak.sigma_s)
    assert 0.05 < peak.sigma_s < 1
    assert peak.width_s == pytest.approx(72, rel=0.03)
    assert peak.height == pytest.approx(1, rel=0.05)
    assert peak.noise == pytest.approx(0.02, rel=0.3)


def test_sigmas_are_true():
    """Over many scans the errors scatter as the sigmas say."""
    rng = np.random.default_rng(2)
    t_s = np.arange(-150.0, 150.0, 3.0)
    truth = rng.uniform(-60, 60, 200)

    peaks = [fit_peak(t_s, simulated_power(t_s, one, rng, noise=0.05)) for one in truth]

    pull = [(peak.time_s - one) / peak.sigma_s for peak, one in zip(peaks, truth, strict=True)]
    assert np.std(pull) == pytest.approx(1, abs=0.15)
    assert abs(np.mean(pull)) < 0.25


@pytest.mark.parametrize(
    ("power", "why"),
    [
        (np.random.default_rng(3).normal(0, 1, 100), "no peak"),
        (np.ones(100), "constant"),
        (np.linspace(0, 1, 100) ** 2, "no peak"),
        (np.full(100, np.nan), "0 samples"),
    ],
)
def test_no_peak(power, why):
    """Noise, a constant, a slope and nothing at all are no peaks, and it says why."""
    assert why in fit_peak(np.arange(100.0), power)


def test_sign():
    """A forward scan that peaks late stood beyond the computed place: encoder minus true > 0."""
    assert offset_along_scan(6.0, 0.0, 1, 20 / 60) == pytest.approx(2)
    assert offset_along_scan(6.0, 0.0, -1, 20 / 60) == pytest.approx(-2)


def test_offsets_of_simulated_scans(tmp_path):
    """Offsets and half-differences come back; azimuth is across, times cos El (60 deg: half)."""
    truths = [("W01", "el", 1, 3.0, 1.5), ("W01", "az", 1, -4.0, 0.5), ("C02", "el", 1, -12.0, 0.0)]
    path = write_scans(tmp_path / "scans.csv", truths, np.random.default_rng(4))

    recordings = measure(path)

    assert len(recordings) == 3 * 4 * 2
    assert np.isfinite(recordings.sigma_y).sum() == 16
    found = {(one.antenna, one.axis): one for one in averages(recordings)}
    for antenna, axis, _, offset, half in truths:
        one, on_sky = found[antenna, axis], 0.5 if axis == "az" else 1.0
        assert one.scans == 8
        assert one.offset / ARCMIN == pytest.approx(offset * on_sky, abs=0.15)
        assert one.half_difference / ARCMIN == pytest.approx(half * on_sky, abs=0.15)


def test_one_direction_alone_has_no_average():
    """A dash stands for what is not known."""
    (line,) = text([Average("W01", "el", "1", np.nan, np.nan, np.nan, 1)]).splitlines()[1:]

    assert line.split() == ["W01", "el", "1", "-", "+-", "-", "-", "1"]


def test_a_late_clock_flips_with_the_direction():
    """A late time tag shifts forward one way and reverse the other, and drops out of the mean."""
    rng = np.random.default_rng(5)
    late_s, t_s = 3.0, np.arange(-150.0, 150.0, 2.0)
    both = [
        offset_along_scan(fit_peak(t_s, simulated_power(t_s, late_s, rng)).time_s, 0, sign, 1 / 3)
        for sign in (1, -1)
    ]

    assert (both[0] - both[1]) / 2 == pytest.approx(late_s / 3, abs=0.25)
    assert (both[0] + both[1]) / 2 == pytest.approx(0, abs=0.25)


@pytest.mark.slow
def test_second_round_is_near_zero(tmp_path):
    """After loading the average a second round is told to be near zero, or not."""
    truths = [("W01", "el", 1, 9.0, 1.0), ("W01", "el", 2, 0.1, 1.0), ("W02", "el", 2, 5.0, 1.0)]
    path = write_scans(tmp_path / "scans.csv", truths, np.random.default_rng(6))

    done = CliRunner().invoke(offsets, [str(path)])

    assert done.exit_code == 0
    lines = done.output.splitlines()
    assert "near zero" not in lines[1]
    assert lines[2].endswith("  near zero")
    assert "NOT near zero" in lines[3]


def test_a_file_of_stars_holds_no_single_axes(tmp_path):
    """TPOINT's has both axes of a star: each scan, of one axis, would be written masked."""
    path = write_scans(
        tmp_path / "scans.csv", [("W01", "el", 1, 3.0, 0.0)], np.random.default_rng(7)
    )
    done = CliRunner().invoke(offsets, [str(path), "-o", str(tmp_path / "offsets.dat")])

    assert isinstance(done.exception, BadInput)
    assert "expected .csv, .ecsv or .parquet" in str(done.exception)
    assert not (tmp_path / "offsets.dat").exists()


def test_written_recordings(tmp_path):
    """The command writes recordings that can be read and that name every scan without a peak."""
    path = write_scans(
        tmp_path / "scans.csv", [("W01", "el", 1, 3.0, 0.0)], np.random.default_rng(7), noise=50
    )
    good = write_scans(
        tmp_path / "good.csv", [("W01", "el", 1, 3.0, 0.0)], np.random.default_rng(8)
    )

    nothing = CliRunner().invoke(offsets, [str(path), "-o", str(tmp_path / "none.csv")])
    done = CliRunner().invoke(offsets, [str(good), "-o", str(tmp_path / "offsets.csv")])

    assert nothing.exit_code == done.exit_code == 0
    assert nothing.output.count("excluded: no peak") == 8
    for n in range(1, 5):
        assert f"(session a, scan {n}, antenna W01, channel 175)\n" in nothing.output
    with (tmp_path / "offsets.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert [row["scan"] for row in rows] == ["1", "1", "2", "2", "3", "3", "4", "4"]
    assert {row["round"] for row in rows} == {"1"}
    night = read(tmp_path / "offsets.csv")
    assert len(night) == 8
    assert night.y / ARCMIN == pytest.approx(np.full(8, 3.0), abs=0.3)
    assert np.isfinite(night.sigma_y).all()
    assert night.at.column("scan_rate") == pytest.approx(np.full(8, RATE * ARCMIN / 60))


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("power", "volts", 3, "no column power"),
        (",el,1,20.0,", ",el,2,20.0,", 4, "changes within a scan"),
        (",el,", ",ra,", 4, "changes within a scan"),
        ("20.0,1,52.75", "-20.0,1,52.75", 4, "changes within a scan"),
    ],
)
def test_bad_scans(tmp_path, old, new, line, words):
    """A missing column, or a value that changes within a scan, is refused with file and line."""
    path = write_scans(tmp_path / "scans.csv", [("W01", "el", 1, 0, 0)], np.random.default_rng(9))
    path.write_text(path.read_text().replace(old, new, 1))

    with pytest.raises(BadInput) as caught:
        measure(path)

    assert str(caught.value).startswith(f"{path}:")
    assert words in str(caught.value)
    assert abs(caught.value.line - line) <= 1

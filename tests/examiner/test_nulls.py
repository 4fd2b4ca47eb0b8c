"""What the examiner draws has the properties that it says, and its counts are right."""

import dataclasses
import json

import numpy as np
import pytest

import pyport.examiner
from pyport.effects import CATALOGUE
from pyport.effects.sky.frame import hour_angle
from pyport.examiner import program, scores
from pyport.examiner.nulls import causes, noises, nulls, nulls_table, schedule
from pyport.recordings.from_table import from_table

KINDS = list(noises.KINDS)


def pointings(rows=20_000, sessions=4, sky="half", seed=0):
    """Return many pointings."""
    return schedule.draw(np.random.default_rng(seed), rows, sessions, sky)


def noise(kind, at, seed=1):
    """Return noise of a kind."""
    return noises.KINDS[kind].draw(np.random.default_rng(seed), at)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_keeps_its_sky_and_rows(kind):
    """As many rows and nights as the case says, every one in its part of the sky."""
    for number in range(6):
        case = nulls.Case(kind, number, nulls.NULL, 1)
        table = nulls.draw(case).table

        assert len(table["el_deg"]) == case.rows
        assert len(set(table["session"])) == case.sessions
        assert np.all(np.diff(table["time_utc"]).astype(float) >= 0)
        assert np.all(np.isfinite(table["d_xel_arcsec"]))
        if case.sky == "low":
            assert table["el_deg"].max() < 32
        if case.sky == "tracked":
            assert len(set(table["source"])) <= schedule.MOST_TRACKED


def test_every_mixture_of_rows_nights_and_sky_is_drawn():
    """45 numbers go through all of them; rows and causes are not tied to each other."""
    some = [nulls.Case("white", n, nulls.NULL, 1) for n in range(45)]
    mixed = {(n % 5, (n + n // 5) % 5) for n in range(25)}

    assert len({(one.rows, one.sessions, one.sky) for one in some}) == 45
    assert len(mixed) == 25


def test_a_case_is_drawn_the_same_again():
    """Same seed, same case; another number, other noise."""
    case = nulls.Case("white", 3, nulls.CAUSE, 1)
    first, again = nulls.draw(case), nulls.draw(case)
    other = nulls.draw(dataclasses.replace(case, seed=2))

    assert np.array_equal(first.table["d_el_arcsec"], again.table["d_el_arcsec"])
    assert first.truth == again.truth
    assert first.truth != other.truth


def test_positions_are_those_of_the_program():
    """Hour angle and declination that follow from azimuth and elevation are the catalogue's."""
    at = pointings(50)
    table = {"az_deg": np.degrees(at.az), "el_deg": np.degrees(at.el), "d_el_deg": at.el * 0}
    header = {"latitude_deg": np.degrees(at.latitude)}
    recordings = from_table(table, header)
    found = hour_angle(recordings.at) + at.ra - schedule.SIDEREAL_RAD_PER_S * at.time_s
    turn = np.unwrap(found)

    assert np.ptp((turn - turn[0] + 1) % (2 * np.pi)) < 1e-6


def test_terms_and_causes_have_the_formulae_of_the_program():
    """The examiner's columns and the catalogue's agree, sign and unit."""
    at = pointings(200)
    table = {
        "az_deg": np.degrees(at.az),
        "el_deg": np.degrees(at.el),
        "d_el_deg": at.el * 0,
        "temperature_c": at.weather["temperature_c"],
    }
    circumstances = from_table(table, {"latitude_deg": np.degrees(at.latitude)}).at

    def theirs(effect, values):
        one = CATALOGUE[effect]
        size = [values[c.name] * c.scale for c in one.coefficients]
        return np.degrees(np.stack([x @ size for x in one.columns(circumstances)], 1)) * 3600

    for n, name in enumerate(scores.ALTAZ):
        effect = "tilt" if name.startswith("tilt") else name
        other = {"tilt_north": 0.0, "tilt_east": 0.0} if effect == "tilt" else {}
        np.testing.assert_allclose(
            causes.columns(at)[:, :, n], theirs(effect, other | {name: 1.0}), atol=1e-6
        )
    for first, effect in enumerate(causes.CAUSES):
        cause = causes.draw(np.random.default_rng(first), at, first, 5.0)
        if cause.begins is None:
            assert cause.effect == effect
            np.testing.assert_allclose(cause.offset, theirs(effect, cause.truth), atol=1e-4)
        else:
            after = (at.night >= cause.begins)[:, None]
            np.testing.assert_allclose(cause.offset, after * theirs("tilt", cause.truth), atol=1e-6)


@pytest.mark.slow
def test_least_squares_of_white_cases_cover_the_hidden_model():
    """Two coefficients of three within one sigma, 19 of 20 within two."""
    z = []
    for number in range(60):
        world = nulls.draw(nulls.Case("white", number, nulls.NULL, 5))
        table = world.table
        columns = scores.altaz(np.radians(table["az_deg"]), np.radians(table["el_deg"]))
        columns = columns.reshape(-1, 7)
        data = np.stack([table["d_xel_arcsec"], table["d_el_arcsec"]], axis=1).ravel()
        inverse = np.linalg.inv(columns.T @ columns)
        error = inverse @ columns.T @ data - list(world.truth.values())
        z += list(np.abs(error) / np.sqrt(np.diag(inverse)) / world.sigma)

    assert np.mean(np.array(z) < 1) == pytest.approx(0.683, abs=0.08)
    assert np.mean(np.array(z) < 2) == pytest.approx(0.954, abs=0.04)


def test_a_cause_is_as_visible_as_asked():
    """What the seven terms leave of it has the rms asked for."""
    at = pointings(300)
    cause = causes.draw(np.random.default_rng(3), at, 0, 4.0)
    base = causes.columns(at).reshape(-1, 7)
    flat = cause.offset.ravel()
    left = flat - base @ np.linalg.lstsq(base, flat, rcond=None)[0]

    assert np.linalg.norm(left) / np.sqrt(300) == pytest.approx(4.0)


def test_a_change_is_expected_by_session_and_since_a_moment():
    """Against the first session it is nothing before the change and all of it after."""
    cause = causes.Cause("epoch_tilt", np.zeros((1, 2)), {"tilt_north": 5.0}, 2)

    assert cause.expected("tilt_north[night 01]") == 0
    assert cause.expected("tilt_north[night 02]") == 5
    assert cause.expected("tilt_north[since 2024-03-05T00:00:00Z]") == 5
    assert cause.expected("tilt_up[night 02]") is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "low", "high"),
    [("scatter-elevation", 2.5, 7), ("scatter-azimuth", 3, 6), ("scatter-session", 3, 6)],
)
def test_scatter_grows_by_the_stated_factor(kind, low, high):
    """The largest scatter over the least."""
    sigma = noise(kind, pointings(sky="half-around")).sigma

    assert low <= sigma.max() / sigma.min() <= high


@pytest.mark.slow
def test_scatter_by_elevation_goes_as_the_air_does():
    """What is left over 1 / sin E is white."""
    at = pointings(sky="wide")
    scaled = noise("scatter-elevation", at).value * np.sin(at.el)[:, None]
    low = at.el < np.median(at.el)

    assert np.std(scaled[low]) / np.std(scaled[~low]) == pytest.approx(1, abs=0.05)


def test_outliers_are_one_in_twenty_and_on_their_side():
    """Both ways: as many up as down; one-sided: none down."""
    at = pointings()
    both, single = noise("outliers-both-ways", at).value, noise("outliers-one-sided", at).value

    assert np.mean(np.abs(both) > 4) == pytest.approx(0.05, abs=0.006)
    assert np.mean(both > 4) == pytest.approx(np.mean(both < -4), abs=0.006)
    assert np.mean(single > 4) == pytest.approx(0.05, abs=0.006)
    assert np.mean(single < -5) == 0


@pytest.mark.slow
def test_skewed_noise_leans_and_has_no_mean():
    """Gamma of shape two: skewness sqrt(2)."""
    value = noise("skewed", pointings()).value
    skewness = np.mean(value**3, axis=0) / np.std(value, axis=0) ** 3

    assert np.abs(skewness) == pytest.approx(np.sqrt(2), abs=0.15)
    assert np.mean(value, axis=0) == pytest.approx(0, abs=0.03)


@pytest.mark.slow
def test_the_axes_hang_together_where_they_should():
    """0.6 to 0.9 either way; nothing in white noise."""
    at = pointings()

    assert 0.58 < abs(np.corrcoef(noise("axes-correlated", at).value.T)[0, 1]) < 0.92
    assert abs(np.corrcoef(noise("white", at).value.T)[0, 1]) < 0.03


@pytest.mark.parametrize("memory_s", [1200.0, 7200.0])
def test_a_drift_forgets_as_stated(memory_s):
    """Its correlation falls to 1/e over its memory."""
    time_s = np.arange(0, 4000 * memory_s, memory_s / 4)
    value = schedule.ou(np.random.default_rng(0), time_s, memory_s)

    assert np.mean(value[4:] * value[:-4]) == pytest.approx(np.exp(-1), abs=0.04)
    assert np.var(value) == pytest.approx(1, abs=0.06)


@pytest.mark.slow
def test_flicker_has_as_much_in_every_octave():
    """Power of 1/f: the same variance of means over 1, 2, 4, 8 hours, white noise apart."""
    time_s = np.arange(0, 256 * 86400, 600.0)
    at = pointings(len(time_s), 1)
    value = noise("flicker", dataclasses.replace(at, time_s=time_s)).value[:, 0]

    def octave(n):
        mean = value[: len(value) // (2 * n) * 2 * n].reshape(-1, 2, n).mean(axis=2)
        return np.var(np.diff(mean, axis=1)) - 2 / n

    assert octave(24) / octave(96) == pytest.approx(1, abs=0.35)


def test_a_random_walk_goes_on_from_night_to_night():
    """The difference of two nights grows with the time between them."""
    far, near = [], []
    for seed in range(40):
        at = pointings(240, 12, seed=seed)
        value = noise("random-walk", at, seed).value[:, 0]
        mean = np.array([value[at.night == n].mean() for n in range(12)])
        near.append(mean[1] - mean[0])
        far.append(mean[11] - mean[0])

    assert np.std(far) > 2 * np.std(near)


def test_a_source_is_off_by_the_same_place_every_time():
    """One source's offsets stay at one length while they turn with the hour angle."""
    at = pointings(4000, 1, "tracked")
    value = noise("source-offsets", at).value
    east, north = (
        np.stack(at.moved(*one), 1)
        for one in ((np.ones(4000), np.zeros(4000)), (np.zeros(4000), np.ones(4000)))
    )

    assert np.hypot(*east.T) == pytest.approx(1, abs=1e-4)
    assert np.sum(east * north, axis=1) == pytest.approx(0, abs=1e-4)
    along_east = np.sum(east * value, axis=1)
    found = [along_east[at.source == one].mean() for one in np.unique(at.source)]
    assert 0.3 < np.std(found) < 1.5


def test_nights_differ_and_rows_of_a_night_do_not():
    """Pairs of rows of one night at one place share what the night has."""
    at = pointings(2400, 12)
    fixed = dataclasses.replace(at, az=np.zeros(2400), el=np.ones(2400))
    value = noise("nights-differ", fixed).value
    mean = np.array([value[at.night == n].mean(axis=0) for n in range(12)])

    assert np.all(np.std(mean, axis=0) > 0.2)


def test_rounded_recordings_come_in_steps_of_two_sigma():
    """Every offset is a whole number of steps."""
    world = nulls.draw(nulls.Case("rounded", 2, nulls.NULL, 1))
    steps = world.table["d_el_arcsec"] / (2 * world.sigma)

    assert steps == pytest.approx(np.round(steps), abs=1e-9)


def test_given_errors_are_those_that_were_drawn():
    """Residuals over the stated errors are standard normal."""
    world = nulls.draw(nulls.Case("sigma-given", 4, nulls.NULL, 1))
    at_rows = len(world.table["el_deg"])
    sigma = world.table["sigma_el_arcsec"]

    assert at_rows == 1200
    growth = sigma * np.sin(np.radians(world.table["el_deg"]))
    assert growth == pytest.approx(growth[0])
    assert np.median(sigma) == pytest.approx(world.sigma)


@pytest.mark.parametrize(
    ("hits", "of", "low", "high"),
    [(0, 100, 0.0, 0.0370), (3, 100, 0.0103, 0.0845), (50, 100, 0.4038, 0.5962)],
)
def test_wilson_intervals(hits, of, low, high):
    """As tabulated in Newcombe 1998, Statistics in Medicine 17, 857."""
    found = scores.counted([True] * hits + [False] * (of - hits)).interval

    assert found == pytest.approx((low, high), abs=5e-4)


def test_a_target_is_missed_only_when_its_interval_is():
    """4 of 100 may be 3 %; 10 of 100 are not."""

    def share(hits):
        return scores.counted([True] * hits + [False] * (100 - hits))

    assert share(3).judged(0, 0.03) == scores.MET
    assert share(4).judged(0, 0.03) == scores.OPEN
    assert share(10).judged(0, 0.03) == scores.MISSED
    assert scores.counted([]).judged(0, 0.03) == scores.NONE


def test_outcomes_that_hang_together_count_less():
    """Seven copies of one outcome are worth one; seven independent ones seven."""
    rng = np.random.default_rng(0)
    single = rng.uniform(size=200) < 0.7
    copies = scores.clustered([[bool(one)] * 7 for one in single])
    free = scores.clustered((rng.uniform(size=(200, 7)) < 0.7).tolist())

    assert copies.effective == pytest.approx(200, rel=0.02)
    assert free.effective > 1100


@pytest.mark.parametrize(
    ("effect", "variant", "name", "value", "sigma", "z"),
    [
        ("temperature", "the same everywhere", "temperature_el", 3.0, 1.0, {"temperature_el": 1.0}),
        ("temperature", "", "temperature_el", 3.0, 1.0, {"temperature_el": 1.0}),
        ("temperature", "the same everywhere", "temperature_xel", 3.0, 1.0, {}),
        ("temperature", "as cos E", "temperature_el", 3.0, 1.0, {}),
        ("drift", "", "temperature_el", 3.0, 1.0, {}),
        ("temperature", "", "temperature_el", None, None, {}),
    ],
)
def test_the_right_finding_is_scored_by_its_sigma(effect, variant, name, value, sigma, z):
    """Value minus truth over sigma of coefficients with the right name, of the right effect."""
    cause = causes.Cause("temperature", np.zeros((1, 2)), {"temperature_el": 2.0})
    parameters = [{"name": name, "value": value, "sigma": sigma}]
    found = {"effect": effect, "variant": variant, "parameters": parameters}

    assert nulls.of_cause({"findings": [found]}, cause) == z
    assert nulls.of_cause({"findings": []}, cause) == {}


def test_scatter_that_is_reported_is_no_claim():
    """A claim is a mismatch with a finding."""
    assert not nulls.claimed({"mismatch": True, "findings": []})
    assert not nulls.claimed({"mismatch": False, "findings": []})
    assert nulls.claimed({"mismatch": True, "findings": [{}]})


@pytest.mark.slow
def test_a_run_goes_on_where_it_stopped(tmp_path, monkeypatch):
    """What is there is not done again, a line cut short is; of another program nothing counts."""
    file = tmp_path / "nulls.jsonl"
    wanted = nulls.cases(["white"], 2, 1, [nulls.NULL])
    first = list(scores.run(wanted, nulls.examine, file))
    file.write_text(file.read_text()[:-20])
    done = []
    real = nulls.examine
    monkeypatch.setattr(nulls, "examine", lambda case: done.append(case) or real(case))
    again = list(scores.run(wanted, nulls.examine, file))

    assert [one.number for one in done] == [1]
    assert [one["z"] for one in again] == [json.loads(json.dumps(one["z"])) for one in first]
    monkeypatch.setattr(program, "version", lambda: "another")
    assert scores.read(file, nulls.Case) == {}


def test_the_table_says_which_targets_are_missed():
    """Every case claimed: the kind is named in the last line."""
    outcome = {
        "part": nulls.NULL,
        "claimed": True,
        "findings": [{"effect": "clock"}],
        "z": {"skew": 0.3, "collimation": 1.4},
    }
    text = nulls_table.text([nulls_table.line("white", [outcome] * 20)])

    assert "20/20" in text
    assert "claimed in white: clock 20" in text
    assert "claims" in text.splitlines()[-1]


def test_no_answer_in_time_is_none(monkeypatch):
    """A diagnosis that goes on is stopped; another one afterwards is not."""
    import time

    monkeypatch.setattr(pyport, "diagnose", lambda *_, **__: time.sleep(60))
    begun = time.monotonic()
    found = program.diagnosed({}, patience_s=0.2)

    assert isinstance(found, program.Refused)
    assert "no answer" in found.why
    assert time.monotonic() - begun < 10


@pytest.mark.slow
def test_the_command_prints_a_line_a_kind_and_goes_on(tmp_path):
    """A kind that there is not is refused; a second run reads what the first one found."""
    from click.testing import CliRunner

    from pyport.cli.dev import command
    from pyport.errors import BadInput

    words = ["nulls", "--cases", "1", "--kinds", "white", "--by", "rows", "--out", str(tmp_path)]
    first, again = (CliRunner().invoke(command, words) for _ in range(2))

    assert first.exit_code == 0
    assert first.output == again.output
    assert "rows 60" in first.output
    assert len((tmp_path / "nulls.jsonl").read_text().splitlines()) == 2
    wrong = CliRunner().invoke(command, ["nulls", "--kinds", "pink"])
    assert isinstance(wrong.exception, BadInput)

"""What no effect explains: fields and boxes stand where the misfit is."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.angles import ARCSEC
from pyport.diagnosis import evidence
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.searching.confirming import _lack
from pyport.diagnosis.searching.instead import _same_bumps, _standing, _together_with
from pyport.diagnosis.searching.winner import trials_of
from pyport.diagnosis.shapes import fields, forms
from pyport.diagnosis.shapes.boxes import boxes, sectors
from pyport.diagnosis.shapes.fields import Ground, Worth, as_candidate, region
from pyport.diagnosis.shapes.forms import Field, families, numbers
from pyport.diagnosis.trial import at_best
from pyport.diagnosis.weighing import projection, weigh
from pyport.effects import Circumstances, Site
from pyport.effects.empirical.fields import from_sun, last_slew
from pyport.fitting.fit import completed, fit
from pyport.formats.models import load
from pyport.mounts import KINDS


def dent(at):
    """Return a dip of 12 arcsec at azimuth 200 deg."""
    off = (at.az - np.radians(200) + np.pi) % (2 * np.pi) - np.pi
    return -12 * np.exp(-0.5 * (off / np.radians(9)) ** 2)


def patch(at):
    """Return an offset of 8 arcsec in a part of the sky."""
    az, el = np.degrees(at.az) % 360, np.degrees(at.el)
    return 8.0 * ((az > 100) & (az < 190) & (el > 25) & (el < 50))


@pytest.mark.slow
def test_a_dent_in_the_rail_is_unknown_and_lies_where_it_is():
    """Harmonics could draw a dip, several at once; one narrow curve does it better."""
    found = diagnose(recordings(1200, 5, y=dent), load("altaz"))
    first = found.findings[0]
    stretch = first.where.region[0]

    assert first.verdict == "unknown"
    assert stretch.column == "az_deg"
    assert 180 < stretch.low < 200 < stretch.high < 220


@pytest.mark.slow
def test_sectors_finer_than_any_harmonic_are_found_though_no_name_sees_them():
    """Sectors of six degrees, too far or too near by the scatter, as it happens: no wave is."""
    signs = np.random.default_rng(0).choice([-5.0, 5.0], 60)
    found = diagnose(
        recordings(600, 5, y=lambda at: signs[(np.degrees(at.az) % 360 // 6).astype(int)]),
        load("altaz"),
    )

    assert [one.variant for one in found.findings] == ["el: follows az_deg"]
    assert found.findings[0].verdict == "unknown"
    assert found.p_value < 1e-4


@pytest.mark.slow
def test_plates_finer_than_any_wave_are_found_though_no_name_sees_them():
    """A chessboard of 25 by 16 deg over the sky: a fit of its bumps without a prior fails."""
    found = diagnose(
        recordings(600, 5, y=lambda at: np.where((at.az // 0.44 + at.el // 0.28) % 2, 8.0, -8.0)),
        load("altaz"),
    )

    assert [one.variant for one in found.findings] == ["el: 6 deg wide"]
    assert found.heldout.after < found.heldout.before - 3 * found.heldout.fall_sigma


def test_a_field_is_worth_what_it_should_gain_on_data_left_out():
    """Of heights drawn from its prior: directions known well gain all, unknown ones nothing."""
    rng = np.random.default_rng(0)
    power = np.array([1e6, 400.0, 9.0, 1.0, 0.01])
    field = Field("f", "v", np.eye(5), np.zeros(5, bool), axes=(0,) * 5, which=tuple(range(5)))
    told = power / (1 + power)
    drawn = rng.normal(size=(4000, 5)) * np.sqrt(power + power**2)
    gains = [float((told * (along**2 / power - 1)).sum()) for along in drawn]
    found = fields.worth(field, np.diag(power), np.diag(power), drawn[0])
    kept = found.spread**2 > fields.FAINT

    assert np.mean(gains) == pytest.approx((told * power).sum(), rel=0.05)
    assert kept.all()
    assert found.directions.shape == (5, len(found.spread))
    assert len(found.spread) < 5
    ratio = found.spread**2 / np.sort(power)[-len(found.spread) :]
    assert ratio == pytest.approx(np.full(len(ratio), ratio[0]))


def test_a_field_has_the_evidence_of_its_prior_wherever_it_is_weighed():
    """As a candidate beside others, and beside noise estimated anew, whatever was left out."""
    problem = prepare(recordings(300, 5, y=dent), load("altaz"))
    weighed = weigh(problem)
    best = max(Ground(problem, weighed, ()).worths((False,)), key=lambda one: one.evidence)
    columns = best.field.columns @ best.directions
    unit = np.sqrt(np.mean(columns**2, axis=0))
    places = np.arange(problem.size, problem.size + len(unit))
    wider = problem.with_columns(columns / unit)
    one = Chosen(as_candidate(best, places, unit), "all")
    trial = projection(wider, weigh(wider), ()).trials([(one.candidate, "all")])[0]
    own, known = wider.expanded([one]), wider.precision([one])
    model = wider.expanded(wider.base)
    _, gained = _lack(weighed.covariance, model, own, wider.residual, known)

    assert trial.evidence == pytest.approx(best.evidence, abs=2)
    assert gained - one.candidate.price == pytest.approx(best.evidence, abs=2)
    assert _lack(weighed.covariance, model, own, wider.residual, 0.0)[1] != pytest.approx(
        gained, abs=2
    )


@pytest.mark.slow
def test_a_structure_that_rests_slowly_after_slews_is_told_from_a_drift():
    """Elevation is off by the way that the telescope came."""
    found = diagnose(
        recordings(600, 5, y=lambda at: 9 * np.clip(np.diff(at.el, prepend=at.el[0]), -0.4, 0.4)),
        load("altaz"),
    )

    assert [one.variant for one in found.findings] == ["el: follows the last slew in el"]
    assert found.findings[0].verdict == "unknown"


@pytest.mark.slow
def test_a_notch_in_the_second_axis_lies_along_its_angle():
    """Of an XY mount: in azimuth and elevation it would be a bow. Two stretches draw its slopes."""
    made = recordings(600, 11)
    at = replace(made.at, mount=KINDS["xy-ns"])
    x, y = 3 * ARCSEC * np.random.default_rng(11).normal(size=(2, 600))
    off = np.abs(np.degrees(at.axes.el) - 20)
    notched = replace(made, at=at, x=x, y=y + 20 * ARCSEC * np.clip(1 - off / 8, 0, None))
    found = diagnose(notched, load("altaz").on(at.mount))
    first, second = (one.where.region[0] for one in found.findings)

    assert [one.variant[:14] for one in found.findings] == ["el: y_deg off "] * 2
    assert (first.column, second.column) == ("y_deg", "y_deg")
    assert (first.low, first.high) == pytest.approx((14, 25), abs=1)
    assert (second.low, second.high) == pytest.approx((17, 27), abs=1)


@pytest.mark.slow
def test_what_depends_on_two_conditions_together_is_a_surface_over_both():
    """Of either alone it is nothing: warm and dry as cold and damp, the other way elsewhere."""

    def both(at):
        warm, damp = at.numbers("temperature_c") - 8, at.numbers("humidity_pct") - 60
        return 5 * np.tanh(warm * damp / 90)

    found = diagnose(recordings(600, 4, y=both), load("altaz"))

    assert [one.variant for one in found.findings] == ["el: follows temperature_c and humidity_pct"]


def test_four_bumps_over_each_of_two_columns_are_worth_most(monkeypatch):
    """Of a product and of an offset in one corner: half or twice as many are worth less."""

    def standard(at):
        return (at.numbers("temperature_c") - 8) / 5, (at.numbers("humidity_pct") - 60) / 17

    def product(at):
        return 5 * np.tanh(np.prod(standard(at), axis=0))

    def corner(at):
        return 6.0 * (np.min(standard(at), axis=0) > 0.3)

    def worth(count):
        monkeypatch.setattr(forms, "OVER_TWO", count)
        return sum(
            one.evidence
            for ground in grounds
            for one in ground.worths((False,))
            if one.field.variant == "el: follows temperature_c and humidity_pct"
        )

    problems = [prepare(recordings(600, 4, y=one), load("altaz")) for one in (product, corner)]
    grounds = [Ground(one, weigh(one, ()), ()) for one in problems]
    now = forms.OVER_TWO

    assert worth(now) > max(worth(now // 2), worth(2 * now)) + 6


def test_that_a_curve_takes_two_columns_must_convince():
    """One that is worth a little less and takes one column comes first; by six it does not."""
    of = {form.variant: form for _, form in families(prepare(recordings(60, 1), load("altaz")))}

    def standing(evidence, variant):
        nothing = np.zeros(0)
        return _standing(Worth(of[variant], evidence, 0.0, nothing, nothing, nothing))

    alone, both = "follows humidity_pct", "follows temperature_c and humidity_pct"
    assert standing(30.0, alone) == 30.0
    assert standing(35.0, both) < standing(30.0, alone) < standing(37.0, both)


def ring(at):
    """Return a ridge of 25 arcsec all around the Sun, 60 deg away from it."""
    return 25 / (1 + ((np.degrees(from_sun(at)) - 60) / 5) ** 2)


def with_the_sun(n, seed, y=None):
    """Return recordings with the Sun's place beside them."""
    rng = np.random.default_rng([seed, 1])
    angles = {"sun_az": rng.uniform(0, 2 * np.pi, n), "sun_el": rng.uniform(-0.5, 1.2, n)}
    return recordings(n, seed, y=y, **angles)


@pytest.mark.slow
def test_what_goes_with_the_distance_from_the_sun_is_found_as_one_finding():
    """It is fine enough to take two turns: what its bumps draw in both is one field."""
    found = diagnose(with_the_sun(600, 5, ring), load("altaz"))
    only = found.findings[0]

    assert [one.variant for one in found.findings] == ["el: follows sun_distance_deg"]
    assert only.verdict == "unknown"
    assert only.visible_rms == pytest.approx(
        np.std(ring(found.problem.recordings.at)) * ARCSEC, rel=0.3
    )


def on_the_cable(seed, y=None):
    """Return 400 pointings whose azimuth is counted over nearly two turns; `y` of it [arcsec]."""
    turn = np.random.default_rng([seed, 2]).integers(-1, 1, 400)
    made = recordings(400, seed, y=y and (lambda at: y(at.az + 2 * np.pi * turn)))
    return replace(made, at=replace(made.at, az=made.at.az + 2 * np.pi * turn))


@pytest.mark.slow
def test_an_angle_that_is_off_from_somewhere_on_is_one_finding():
    """On the sky it falls as the cosine of the second angle: no patch, and no turn of anything."""

    def off(at):
        return 10 * np.cos(at.el) * ((at.az > np.radians(215)) | (at.az < np.radians(40)))

    (one,) = diagnose(recordings(400, 8, x=off), load("altaz")).findings
    (region,) = one.where.region

    assert (one.verdict, region.column) == ("unknown", "az_deg")
    assert one.variant.startswith("xel: az_deg off from")
    # Inside or outside is the same, for a zero is fitted.
    assert sorted((region.low, region.high)) == pytest.approx([40, 215], abs=2)
    assert "slipped" in one.decide_by


def test_the_first_axis_of_any_mount_may_be_off_in_a_part_of_its_circle():
    """Of an equatorial one it is the hour angle, and falls as the cosine of declination."""
    mount, quiet = KINDS["equatorial"], recordings(400, 8)
    at = replace(quiet.at, mount=mount)
    off = 60 * at.onto_sky * (np.abs(at.axes.az - 0.2) < 0.9)
    noise = np.random.default_rng(9).normal(size=(2, 400)) * 5
    made = replace(quiet, at=at, x=(off + noise[0]) * ARCSEC, y=noise[1] * ARCSEC)
    problem = prepare(made, load(mount.model), seed=1)
    found, _ = sectors(Ground(problem, weigh(problem), ()))
    edges = sorted((edge + np.pi) % (2 * np.pi) - np.pi for edge in found.bumps["az_rad"])

    assert found.region[0].column == "hour_angle_deg"
    assert edges == pytest.approx([-0.7, 1.1], abs=0.05)


@pytest.mark.slow
def test_a_stretch_of_the_second_axis_is_no_two_jumps():
    """A bit of an encoder that is lost there displaces what lies between two edges."""
    off = np.radians(40), np.radians(47)
    y = lambda at: 8.0 * ((at.el > off[0]) & (at.el < off[1]))  # noqa: E731 - one line
    (one,) = diagnose(recordings(300, 8, y=y), load("altaz")).findings
    (region,) = one.where.region

    assert (one.verdict, region.column, one.where.axes) == ("unknown", "el_deg", ("el",))
    assert (region.low, region.high) == pytest.approx((40, 47), abs=1)


OPEN = np.random.default_rng(5).random(240) < 0.4
COLUMNS = {
    "labels": {"dome_vent": np.where(OPEN, "open", "shut")},
    "numbers": {"last_slew": np.where(OPEN, 1.0, -1.0)},
    "blank cells": {"dome_vent": np.where(OPEN, "open", np.resize(["shut", "shut", ""], 240))},
    "three": {"observer": np.where(OPEN, "AB", np.resize(["CD", "EF"], 240))},
}


@pytest.mark.slow
@pytest.mark.parametrize("columns", COLUMNS.values(), ids=COLUMNS)
def test_a_column_of_few_values_is_found_by_an_offset_for_each(columns):
    """No curve goes through two numbers, and none through labels."""
    (name,) = columns
    made = recordings(240, 8, y=lambda _: 6.0 * OPEN, **columns)
    (one,) = diagnose(made, load("altaz")).findings

    assert (one.verdict, one.variant) == ("unknown", f"el: by {name}")
    assert "by turns" in one.decide_by


FEW = {
    "a label for every source": ({"chart": np.array([f"c{n // 8}" for n in range(240)])}, False),
    "twelve labels": ({"chart": np.array([f"c{n % 12}" for n in range(240)])}, True),
    "thirteen": ({"chart": np.array([f"c{n % 13}" for n in range(240)])}, False),
    "five numbers": ({"step": np.arange(240.0) % 5}, True),
    "a curve's": ({"step": np.arange(240.0) % 6}, False),
    "one value": ({"chart": np.full(240, "c")}, False),
    "one that is seen often": ({"chart": np.where(np.arange(240) < 7, "a", "b")}, False),
    "what effects ask for": ({"scan_direction": np.where(OPEN, 1.0, -1.0)}, False),
}


@pytest.mark.parametrize(("columns", "there"), FEW.values(), ids=FEW)
def test_which_columns_have_few_values(columns, there):
    """Two of them must be seen often enough to compare, and no effect may know the column."""
    problem = prepare(recordings(240, 8, **columns), load("altaz"), seed=1)

    assert bool([*forms._levels(problem)]) == there


def test_what_goes_with_the_cable_is_a_curve_of_azimuth_beyond_a_turn():
    """Cubed in azimuth as the axis counts it: on the circle two curves lie over each other."""
    found = diagnose(on_the_cable(1, lambda az: (az / np.pi) ** 3), load("altaz"))

    assert [(one.verdict, one.where.axes) for one in found.findings] == [("unknown", ("el",))]


def test_a_circle_of_azimuth_has_no_cable():
    """Within a turn both curves are one."""
    of = [field.variant for _, field in families(prepare(recordings(60, 1), load("altaz")))]
    beyond = [field.variant for _, field in families(prepare(on_the_cable(1), load("altaz")))]

    assert set(beyond) - set(of) == {"follows unwrapped_az_deg"}


def test_the_distance_from_the_sun_is_an_angle_between_directions():
    """Recorded places of the Sun are used; without them, time and site would do."""
    at = Circumstances(
        np.radians([10, 190, 10.0]),
        np.radians([30, 30, 90.0]),
        Site(0.9),
        {"sun_az": np.radians([10, 10, 70.0]), "sun_el": np.radians([10, 60, 25.0])},
    )

    assert np.degrees(from_sun(at)) == pytest.approx([20, 90, 65])
    assert not any(
        "sun" in field.variant for _, field in families(prepare(recordings(60, 1), load("altaz")))
    )


def test_what_the_same_bumps_draw_in_a_second_turn_joins_the_first():
    """On one axis first and on both then: one field, whose columns draw both."""
    problem = prepare(recordings(200, 3), load("altaz"))
    form = next(one for _, one in families(problem) if one.variant == "follows temperature_c")
    first = replace(form, axes=(1, 1, 1), which=(0, 4, 9), variant="el: a")
    second = replace(form, axes=(0, 0, 1, 1, 1), which=(2, 3, 0, 4, 9), variant="both axes: a")
    rng = np.random.default_rng(0)
    early, late = (
        Worth(one, 20.0, 25.0, rng.normal(size=(len(one.axes), 2)), rng.normal(size=2), spread)
        for one, spread in ((first, np.array([1.0, 2.0])), (second, np.array([3.0, 4.0])))
    )
    chosen = SimpleNamespace(candidate=as_candidate(early, np.arange(2), np.ones(2)))
    winner = SimpleNamespace(evidence=20.0, gain=25.0, values=early.values)
    step = SimpleNamespace(chosen=chosen, winner=winner)
    for one in (replace(early, field=second), late):
        assert _same_bumps(step, one.field)
    assert not _same_bumps(step, replace(first, axes=(0, 0, 0)))
    joined = _together_with(step, late)

    assert joined.field.variant == "both axes: a"
    assert (joined.evidence, joined.gain) == (40.0, 50.0)
    assert joined.spread == pytest.approx([1, 2, 3, 4])
    curve = sum(one.field.columns @ one.directions @ one.values for one in (early, late))
    assert joined.field.columns @ joined.directions @ joined.values == pytest.approx(curve)


def test_the_last_slew_stays_while_a_source_is_tracked():
    """Each antenna slews by itself; before its first slew nothing is known."""
    degrees = np.radians([0, 100, 30, 31, 33.0, 100.2, 31.5])
    at = Circumstances(
        degrees,
        np.full(7, 0.7),
        Site(0.9),
        {
            "time": np.array([0, 1, 10, 20, 40, 12, 30.0]),
            "antenna": np.array(list("ABAAABA")),
        },
    )
    nowhere = np.nan

    assert np.degrees(last_slew(at)[0]) == pytest.approx(
        [nowhere, nowhere, 30, 30, 1.5, nowhere, 30], nan_ok=True
    )
    assert last_slew(at)[1] == pytest.approx([nowhere, nowhere, 0, 0, 0, nowhere, 0], nan_ok=True)


@pytest.mark.slow
def test_a_part_of_the_sky_comes_back_with_its_edges():
    """A box in azimuth and elevation is found to a few degrees on all four sides."""
    found = diagnose(recordings(1200, 6, y=patch), load("altaz"))
    first = found.findings[0]
    edges = {one.column: (one.low, one.high) for one in first.where.region}

    assert first.verdict == "unknown"
    assert edges["az_deg"] == pytest.approx((100, 190), abs=6)
    assert edges["el_deg"] == pytest.approx((25, 50), abs=3)


@pytest.mark.slow
def test_a_named_effect_keeps_its_name_beside_all_fields():
    """A smooth field can draw a harmonic, too, but must not win over it."""
    nodding = diagnose(recordings(1200, 7, y=lambda at: 6 * np.sin(3 * at.az)), load("altaz"))

    assert [one.members for one in nodding.findings] == [("elevation_harmonics",)]


@pytest.mark.parametrize("refit", [None, ()])
def test_the_best_box_is_the_one_that_was_put_there(refit):
    """The scan over all boxes and the climb of their edges end at the offset, a zero or none."""
    measured = recordings(1500, 8, y=patch)
    model = completed(fit(measured, load("altaz")))
    problem = prepare(replace(measured, y=measured.y + 20 * ARCSEC), model, refit)
    ground = Ground(problem, weigh(problem), ())
    along = next(one for one in boxes(ground) if one.variant.startswith("el"))
    az, el = along.region

    assert (az.low, az.high) == pytest.approx((100, 190), abs=6)
    assert (el.low, el.high) == pytest.approx((25, 50), abs=3)
    assert ground.worth_of(along).evidence > 50


def test_noise_alone_is_worth_no_field():
    """Averaged over all forms that it could take, no field explains white noise."""
    problem = prepare(recordings(800, 9), load("altaz"))
    worths = list(Ground(problem, weigh(problem), ()).worths())

    assert len(worths) > 50
    assert max(one.evidence for one in worths) < 10


def test_fields_of_time_are_left_out_where_only_lasting_ones_are_asked_for():
    """All others are the same."""
    problem = prepare(recordings(200, 9), load("altaz"))
    ground = Ground(problem, weigh(problem), ())
    every, lasting = list(ground.worths()), list(ground.worths([False]))
    kept = [one.evidence for one in every if not one.field.of_time]

    assert 0 < len(lasting) < len(every)
    assert [one.evidence for one in lasting] == kept


def test_evidence_is_that_of_the_best_normal_prior():
    """For one coefficient it is gain - 1 - log(gain) where the prior may be any."""
    gain = 30.0
    evidence, variance = at_best(np.array([4.0]), np.array([np.sqrt(4.0 * gain)]))

    assert evidence == pytest.approx(gain - 1 - np.log(gain), abs=0.2)
    assert variance * 4 == pytest.approx(gain - 1, rel=0.4)


def test_a_curve_that_swings_everywhere_has_no_place():
    """Only a narrow stretch beyond half the peak is a region."""
    values = np.linspace(0, 100, 1000)
    is_y = np.zeros(1000, bool)
    field = Field("a smooth curve", "follows x", values[:, None], is_y, along=("x", values))

    assert region(field, np.tanh((values - 50) / 5)) == ()
    (narrow,) = region(field, np.exp(-0.5 * ((values - 40) / 4) ** 2))
    assert (narrow.low, narrow.high) == pytest.approx((35.3, 44.7), abs=0.5)


@pytest.mark.parametrize(("blank", "known"), [(0, True), (1, True), (149, True), (151, False)])
def test_a_blank_cell_hides_no_column(blank, known):
    """What most rows have a misfit may follow; the other rows have none of its curves."""
    column = np.linspace(-5.0, 25.0, 300)
    column[:blank] = np.nan
    made = recordings(300, 3, grease_c=column)

    assert ("grease_c" in numbers(made)) == known
    bumps = [
        each
        for _, each in families(prepare(made, load("altaz")))
        if each.variant == "follows grease_c"
    ]
    assert len(bumps) == known
    assert all(np.isfinite(one.values).all() for one in bumps)


@pytest.mark.parametrize(("values", "followed"), [(4, False), (5, False), (6, True), (12, True)])
def test_numbers_of_five_values_have_an_offset_each_and_of_six_a_curve(values, followed):
    """A curve through six has bends of its own."""
    made = recordings(300, 3, valve=np.resize(np.arange(values, dtype=float), 300))
    found = {one.variant for _, one in families(prepare(made, load("altaz")))}

    assert ("valve" in numbers(made)) == followed
    assert ("follows valve" in found) == followed
    assert ("by valve" in found) != followed


def test_how_many_columns_go_together_decides_nothing(monkeypatch):
    """One at a time or all at once: the same evidence of every field and every candidate."""
    problem = prepare(recordings(120, 12), load("altaz"))
    weighed = weigh(problem)
    found = []
    for size in (1, 1 << 30):
        monkeypatch.setattr(fields, "WHITENED", size)
        monkeypatch.setattr(evidence, "TOGETHER", size)
        worths = Ground(problem, weighed, ()).worths()
        trials = trials_of(problem, projection(problem, weighed, ()))
        found.append([one.evidence for one in (*worths, *trials)])

    assert len(found[0]) > 250
    assert found[0] == pytest.approx(found[1], rel=1e-9, abs=1e-9)

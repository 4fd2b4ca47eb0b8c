"""Every kind of case is what it says, and the same when made again."""

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.errors import BadInput
from pyport.examiner.worlds.faults import CATALOGUED, OCCASIONAL, SWALLOWED, UNCATALOGUED
from pyport.examiner.worlds.kinds import HIDEABLE, KINDS, make_case
from pyport.examiner.worlds.mount import Base
from pyport.examiner.worlds.twins import TWINS

ROWS = 240


@pytest.mark.slow
@pytest.mark.parametrize("effect", HIDEABLE)
def test_a_hidden_cause_has_the_rho_that_was_asked_for(effect):
    """After the altaz base took its share the cause is rho times the noise on its greater axis."""
    case = make_case("one", 3, effect=effect, rho=0.5, rows=ROWS)
    (cause,) = case.truth["effects"]

    assert cause["effect"] == effect.removeprefix("wandering_")
    assert max(cause["rho_xel"], cause["rho_el"]) == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("seed", range(6))
def test_nothing_hidden_leaves_nothing(seed):
    """What the altaz base leaves of a null case is a fifth of a sigma, all rows taken together."""
    case = make_case("null", seed, noise="white")
    noise = case.truth["noise"]
    base = Base(
        case.base,
        case.columns["antenna"],
        (~np.isnan(case.columns["d_az_deg"]), ~np.isnan(case.columns["d_el_deg"])),
        (noise["xel_arcsec"] * ARCSEC, noise["el_arcsec"] * ARCSEC),
    )

    assert np.hypot(*base.rho(*case.clean)) * np.sqrt(len(case.base[0])) < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["null", "rt32", "gmrt"])
def test_no_telescope_looks_below_its_horizon_or_through_its_zenith(kind):
    """Sources are left when they leave the elevations that the telescope reaches."""
    el = make_case(kind, 3).columns["el_deg"]

    assert 5 < el.min() < 35
    assert 60 < el.max() < 86


@pytest.mark.parametrize("effect", UNCATALOGUED)
def test_a_stranger_is_called_unknown(effect):
    """Causes outside the catalogue carry no name that a solver could guess."""
    case = make_case("unknown", 3, effect=effect, rho=1.0, rows=ROWS)
    (cause,) = case.truth["effects"]

    assert cause["class"] == ["unknown"]
    assert max(cause["rho_xel"], cause["rho_el"]) == pytest.approx(1.0, rel=0.02)


@pytest.mark.parametrize("effect", SWALLOWED)
def test_a_held_model_shows_what_the_base_would_swallow(effect):
    """Against a held model rho counts the whole cause, and the solver is told to hold it."""
    case = make_case("held", 3, effect=effect, rho=0.5, rows=ROWS)
    (cause,) = case.truth["effects"]

    assert max(cause["rho_xel"], cause["rho_el"]) == pytest.approx(0.5, rel=0.02)
    assert case.arguments == ("--model", "none", "--refit", "none")


@pytest.mark.parametrize("twin", TWINS)
def test_a_twin_names_all_of_its_class(twin):
    """The truth of a degenerate case is a class of at least two names of the catalogue."""
    (cause,) = make_case("degenerate", 3, effect=twin, rows=ROWS).truth["effects"]

    assert len(cause["class"]) >= 2
    assert set(cause["class"]) <= set(CATALOGUED)


@pytest.mark.parametrize("kind", ["null", "one", "two", "held", "unknown", "degenerate"])
def test_the_same_seed_makes_the_same_case(kind):
    """Made twice, a case is the same to the last bit; another seed makes another."""
    first, again, other = (make_case(kind, seed, rows=ROWS) for seed in (8, 8, 9))

    assert first.truth == again.truth
    assert all(np.array_equal(v, again.columns[k], equal_nan=v.dtype.kind == "f")
               for k, v in first.columns.items())  # fmt: skip
    assert not np.array_equal(first.columns["el_deg"], other.columns["el_deg"])


def test_amplitude_zero_is_the_same_case_with_nothing_in_it():
    """With rho zero the plan, the noise and every covariate stay, and the cause is gone."""
    with_it = make_case("one", 4, effect="drift+sag_sine", rho=0.5, rows=ROWS, noise="white")
    without = make_case("one", 4, effect="drift+sag_sine", rho=0.0, rows=ROWS, noise="white")
    same = set(with_it.columns) - {"d_az_deg", "d_el_deg"}

    assert not np.any(without.signature)
    assert np.any(with_it.signature)
    assert all(np.array_equal(with_it.columns[name], without.columns[name]) for name in same)


def test_every_case_carries_all_covariates_and_some_that_do_nothing():
    """No column tells what is hidden by being there: all cases have the same ones."""
    ours = [
        set(make_case(k, 1, rows=ROWS).columns) - {"scan_axis"} for k in ("null", "one", "unknown")
    ]

    assert ours[0] == ours[1] == ours[2]
    assert {"operator", "tsys_k", "humidity_pct", "sun_el_deg", "frequency_mhz"} <= ours[0]


def test_the_array_shares_a_time_tag_and_nothing_else():
    """Of an array the truth has play and place for each antenna, and a time tag for each day."""
    effects = {one["effect"]: one["values"] for one in make_case("gmrt", 1).truth["effects"]}

    assert len(effects["scan_direction"]["antenna"]) == 30
    assert len(effects["scan_timing"]["session"]) == 4
    assert max(map(abs, effects["site_longitude"]["antenna"].values())) > 8000


@pytest.mark.slow
def test_the_rt32_campaign_has_the_published_numbers_of_rows():
    """2758 altitude and 2857 azimuth offsets, one axis a row, azimuth within the cable's."""
    case = make_case("rt32", 1)

    assert np.sum(~np.isnan(case.columns["d_el_deg"])) == 2758
    assert np.sum(~np.isnan(case.columns["d_az_deg"])) == 2857
    assert np.abs(case.columns["az_deg"]).max() <= 271
    assert case.header["azimuth_zero"] == "south"


def test_an_ablation_hides_each_step_that_was_left_out():
    """The steps that the steering did not take are the causes, each of the size of nature."""
    case = make_case("ablation", 1, effect="nutation+ut1", rows=600)

    assert [one["effect"] for one in case.truth["effects"]] == ["nutation", "clock"]
    assert all(one["size"] == 1 for one in case.truth["effects"])


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        ({"kind": "nul"}, "no kind is called 'nul'"),
        ({"kind": "one", "effect": "gremlins"}, "no effect is called 'gremlins'"),
        ({"kind": "null", "noise": "pink"}, "no noise is called 'pink'"),
        ({"kind": "null", "site": "moon"}, "no site is called 'moon'"),
    ],
)
def test_an_unknown_name_is_told_with_the_known_ones(wrong, expected):
    """A name that does not exist is answered by the names that do."""
    with pytest.raises(BadInput, match=expected):
        make_case(wrong.pop("kind"), 1, **wrong)


def test_all_kinds_are_explained():
    """Each kind says in a few words what it hides."""
    assert all(KINDS.values())


@pytest.mark.parametrize(
    ("effect", "kind"),
    [(one, "array" if one == "some_antennas" else "one") for one in OCCASIONAL],
)
def test_an_occasional_cause_has_the_rho_that_was_asked_for(effect, kind):
    """At a moment anywhere, in some antennas, on a condition, on a mount that has it."""
    mount = {"fork_flexure": "fork", "declination_axis_flexure": "german", "pier_flip": "german"}
    case = make_case(kind, 3, effect=effect, rows=ROWS, mount=mount.get(effect))
    (cause,) = case.truth["effects"]

    assert max(cause["rho_xel"], cause["rho_el"]) == pytest.approx(0.5, rel=0.03)


def test_what_some_antennas_have_the_others_have_not():
    """Of an array whose truth names them."""
    case = make_case("array", 4, rows=ROWS, noise="white")
    (cause,) = case.truth["effects"]
    has = np.isin(case.columns["antenna"], cause["where"]["subset"]["antenna"])
    added = np.hypot(*case.signature)

    assert 0 < has.mean() < 1
    assert added[~has].max() == 0
    assert added[has].max() > 0


def test_a_file_with_little_in_it_has_no_more():
    """The place and the offsets, or these and the time."""
    place, time = (
        set(make_case("null", 3, rows=60, little=one).columns) for one in ("place", "time")
    )

    assert time - place == {"time_utc"}
    assert place - {"scan_axis"} == {"az_deg", "el_deg", "d_az_deg", "d_el_deg"}

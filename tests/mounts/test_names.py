"""Effects in the words of a mount: complete, and without those of another."""

import dataclasses
import re

import numpy as np
import pytest
from effects.cases import AT

from pyport.effects import CATALOGUE, catalogue, describe, known
from pyport.effects.base import AXES, SKY
from pyport.effects.degeneracies import ELSEWHERE, decisions
from pyport.errors import BadInput
from pyport.formats.models import load
from pyport.mounts import BY_MODEL, KINDS

OTHERS = [one for one in KINDS.values() if one.id != "altaz"]
FOREIGN = re.compile(r"azimuth|elevation|xel|\btilt_(north|east)|\bcos E|\bsin A")


@pytest.mark.parametrize("mount", OTHERS, ids=lambda one: one.id)
def test_no_words_of_another_mount(mount):
    """What acts about the axes is told by their names: ids, sentences, patterns, coefficients."""
    for effect in catalogue(mount).values():
        if effect.acts_in == SKY or effect.mounts != (mount.model,) or not effect.of:
            continue
        said = [effect.id, effect.sentence, effect.pattern, *effect.formula]
        said += [one.name for one in effect.coefficients]

        assert not FOREIGN.search(" | ".join(said)), effect.id


@pytest.mark.parametrize("mount", OTHERS, ids=lambda one: one.id)
def test_families_keep_the_words(mount):
    """Members that are tried, and those that a file tells, speak as the family does."""
    for effect in catalogue(mount).values():
        if effect.of and effect.missing(AT) is None:
            for one in effect.variants(AT):
                assert one.id == effect.id
                assert one.acts_in == SKY or one.of == effect.of
                if effect.make is not None and one.member:
                    assert effect.make(**one.member).id == effect.id


def test_every_effect_says_where_it_acts():
    """In the axes, on the sky, or it finds its way: those that follow the sky, and a rotator."""
    lost = {
        effect.id
        for mount in KINDS.values()
        for effect in catalogue(mount).values()
        if effect.acts_in not in (AXES, SKY) and not effect.of
    }

    assert lost == {
        *("backlash_azimuth", "backlash_elevation", "servo_lag_azimuth", "servo_lag_elevation"),
        "rotator_circle",
    }


def test_every_id_is_known_once():
    """An id means one effect, whatever the mount; those of alt-azimuth mounts come first."""
    for mount in KINDS.values():
        for name, effect in catalogue(mount).items():
            assert (known(name).of or name) == (effect.of or effect.id)
    assert known("tilt") is CATALOGUE["tilt"]
    assert known("no such effect") is None


@pytest.mark.parametrize(
    ("mount", "pair"),
    [(BY_MODEL[model], one) for model, pairs in ELSEWHERE.items() for one in pairs],
    ids=lambda one: getattr(one, "id", None) or " ".join(getattr(one, "ids", ())),
)
def test_what_looks_alike_on_a_mount(mount, pair):
    """One draws what the other does, with what is fitted beside them; what decides is said so."""
    at = dataclasses.replace(AT, mount=mount)
    part = slice(len(at), None) if pair.where == "elevation only" else slice(None)
    own, other, *beside = (
        np.concatenate(CATALOGUE.get(one, known(one)).columns(at))[part]
        for one in (*pair.ids, *pair.beside)
    )
    if pair.exact:
        model = np.concatenate([other, *beside], axis=1)
        left = own - model @ np.linalg.lstsq(model, own, rcond=None)[0]
        assert np.linalg.norm(left) < 1e-9 * np.linalg.norm(own)
    else:
        model = np.concatenate(beside, axis=1)
        own, other = (x - model @ np.linalg.lstsq(model, x, rcond=None)[0] for x in (own, other))
        share = np.linalg.norm(np.linalg.qr(other)[0].T @ own) / np.linalg.norm(own)
        assert 0.95 < share < 0.99
    names = [one.id for one in catalogue(mount).values() if (one.of or one.id) in pair.ids]
    assert len(names) == 2
    if any(known(name).of for name in names):
        assert not FOREIGN.search(" ".join(decisions(names)).replace("azimuth axis", ""))


@pytest.mark.parametrize("mount", OTHERS, ids=lambda one: one.id)
def test_the_catalogue_of_a_mount_is_listed(mount):
    """Every effect that it may have, in its words, and what looks alike on it."""
    text = describe.listing(mount=mount)
    entries = {one["id"]: one for one in describe.entries(mount=mount)}
    pairs = {
        name: {other["effect"] for other in one["looks_like"]} for name, one in entries.items()
    }

    assert set(entries) == set(catalogue(mount))
    if mount.model == "xy":
        assert pairs["sag_cosine"] == {"x_scale", "x_eccentricity"}
        assert pairs["clock"] == {"x_axis_tilt"}
    else:
        assert pairs["clock"] == pairs["site_longitude"] == {"hour_angle_zero"}
        assert pairs["fork_flexure"] == {"polar_axis"}
    assert "looks exactly like" in text


def test_the_classical_model_of_each_mount():
    """`altaz` on another mount is that mount's model; a model of another mount is refused."""
    for mount in OTHERS:
        ids = [term.effect.id for term in load("altaz").on(mount).terms]
        assert ids == [term.effect.id for term in load(mount.model).terms]

    with pytest.raises(BadInput, match="hour_angle_zero is none of an alt-azimuth mount"):
        load("equatorial").on(KINDS["altaz"])
    with pytest.raises(BadInput, match="expected a model such as equatorial"):
        load("rt32-exact").on(KINDS["german"])

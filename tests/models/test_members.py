"""Every member of every family comes back from a file as it was, for any directions."""

import json
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from effects import heavens, mechanics
from effects.cases import AT

from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.shapes.forms import families
from pyport.effects import CATALOGUE, Circumstances, MissingColumn
from pyport.effects.empirical.fields import KINDS, field, values
from pyport.effects.telescope.structure import FreeEdge, SoftEdge, jump_above
from pyport.errors import BadInput
from pyport.formats.model_file import WORDS
from pyport.formats.models import load
from pyport.models.members import apart, effect_of, frozen
from pyport.mounts import KINDS as KINDS_OF_MOUNTS
from pyport.toml_text import toml_spelled

sys.path.insert(0, str(Path(__file__).parent.parent / "diagnosis"))
import made

FIELD = {"axes": [0], "which": [0], "directions": [[1.0]], "family": "a", "variant": "b"}
CASES = [*mechanics.CASES, *heavens.CASES]


def there_and_back(member):
    """Return a member as JSON and then TOML give it back."""
    table = json.loads(json.dumps({"member": dict(member)}))
    return tomllib.loads(toml_spelled({"term": [table]}))["term"][0]["member"]


def place(identity):
    """Return circumstances in which an effect can be seen: those of its case."""
    return next((case.at for case in CASES if case.effect == identity), AT)


@pytest.mark.parametrize("identity", CATALOGUE)
def test_every_variant_comes_back(identity):
    """What a file tells of each member of a family gives its columns where it was not tried."""
    at = place(identity)
    try:
        tried = CATALOGUE[identity].variants(at)
    except MissingColumn:
        pytest.skip("these circumstances cannot show it")
    elsewhere = at.take(np.arange(len(at)) % 3 > 0)
    for one in tried:
        back = effect_of(identity, there_and_back(one.member))

        assert [c.name for c in back.coefficients] == [c.name for c in one.coefficients]
        for mine, others in zip(back.columns(elsewhere), one.columns(elsewhere), strict=True):
            np.testing.assert_array_equal(mine, others)


def test_a_mean_of_the_recordings_is_kept():
    """A temperature is counted from the mean where it was fitted, wherever it is applied."""
    at = place("temperature")
    kept = frozen(CATALOGUE["temperature"], at)
    warm = at.take(at.column("temperature_c") > kept.member["reference_c"])

    assert (
        np.abs(kept.columns(warm)[0]).sum()
        > 2 * np.abs(CATALOGUE["temperature"].columns(warm)[0]).sum() * 0.99 / 2
    )
    assert kept.columns(warm)[0][:, 0].min() > 0
    alone = frozen(apart(CATALOGUE["temperature"])[1], at)
    np.testing.assert_array_equal(alone.columns(warm)[1][:, 0], kept.columns(warm)[1][:, 1])


@pytest.mark.parametrize("vocabulary", WORDS)
def test_words_of_other_programs_come_back(vocabulary):
    """A harmonic, a term with a sign, a ratio: by their shapes, whatever they are called."""
    names = {
        "tpoint": ["IE", "AW", "HESA2", "HSCA5CE8"],
        "tpoint-equatorial": ["ID", "NP", "ME", "HDCH2"],
        "ska-mid": ["ECEC", "HESE8"],
    }
    for name in names.get(vocabulary, ["P3", "P6", "P12", "P15"]):
        effect = WORDS[vocabulary](name).effect()
        back = effect_of(effect.id, there_and_back(effect.member))

        assert back.coefficients == effect.coefficients
        for mine, others in zip(back.columns(AT), effect.columns(AT), strict=True):
            np.testing.assert_array_equal(mine, others)


def bumps():
    """Return an example of every kind of field."""
    time = AT.numbers("time")
    return {
        "sky": {"width_rad": 0.5},
        "wave": {"around": 2, "upward": 1},
        "azimuth": {"width_rad": 0.3},
        "pair": {
            "names": ["temperature_c", "el_deg"],
            "count": 4,
            "values": [AT.numbers("temperature_c").tolist(), np.linspace(0.2, 1.4, 20).tolist()],
        },
        "cycle": {"name": "az_deg", "period_rad": 0.2, "count": 8, "from_rad": 0.0, "falls": True},
        "elevation": {"width_rad": 0.1, "centres_rad": [0.2, 0.3, 0.4]},
        "column": {
            "name": "temperature_c",
            "count": 10,
            "values": AT.numbers("temperature_c").tolist(),
        },
        "slew": {"name": "el_deg", "count": 10, "values": np.linspace(-0.5, 0.5, 20).tolist()},
        "sun": {"count": 10, "values": np.linspace(0.2, 2.5, 20).tolist()},
        "repeat": {"period_s": 7000.0, "since_s": float(time.min()), "count": 8},
        "levels": {"name": "source", "values": ["S3", "S4"]},
        "time": {"length_s": 3600.0, "centres_s": [time.min(), time.mean()]},
        "box": {"az_rad": [6.0, 6.6], "el_rad": [0.3, 0.9]},
        "sector": {"az_rad": [3.5, 7.0]},
        "waves": {"each": [[1, 2], [2, 1]]},
        "stretch": {"name": "el_deg", "low_rad": 0.4, "high_rad": 0.9},
        "curve": {"name": "az_deg", "low": 1.0, "high": 5.5, "order": 4},
    }


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_field_comes_back(kind):
    """Its bumps, mixed into fewer directions, on both axes."""
    told = {"kind": kind, **bumps()[kind]}
    k = values(told, AT).shape[1]
    which = [0, k - 1, k - 1]
    one = field(told, [0, 0, 1], which, [[1.0, 0.5], [0.25, -1.0], [2.0, 0.0]], "a", "b")
    back = effect_of("unknown", there_and_back(one.member))
    x, y = back.columns(AT)

    np.testing.assert_array_equal(x, one.columns(AT)[0])
    np.testing.assert_array_equal(y, one.columns(AT)[1])
    np.testing.assert_array_equal(y[:, 0], 2 * values(told, AT)[:, k - 1])
    assert np.abs(x).max() > 0


def test_a_field_in_the_axes_of_a_mount_comes_back_along_their_angles():
    """Bumps along Y of an XY mount are those along elevation, Y for elevation."""
    at = replace(AT, mount=KINDS_OF_MOUNTS["xy-ns"])
    told = {"kind": "elevation", "width_rad": 0.1, "centres_rad": [0.2, 0.4], "in_axes": True}
    one = field(told, [1], [1], [[1.0]], "a", "b")
    back = effect_of("unknown", there_and_back(one.member))
    height = at.mount.angles(at.az, at.el, 0.0)[1]

    np.testing.assert_allclose(back.columns(at)[1][:, 0], np.exp(-50 * (height - 0.4) ** 2))


def test_every_form_that_a_diagnosis_tries_can_be_kept():
    """The bumps of the search are those that a file gives back."""
    problem = prepare(made.recordings(300, 1), load("altaz"))
    at, row = problem.recordings.at, problem.stack.row
    found = [one for _, one in families(problem)]

    assert len(found) > 40
    for one in found:
        k = one.values.shape[1]
        effect = field(one.bumps, [0] * k, range(k), np.eye(k).tolist(), one.family, one.variant)
        back = effect_of("unknown", there_and_back(frozen(effect, at).member))
        np.testing.assert_array_equal(back.columns(at)[0][row], one.values)


def test_a_curve_stays_at_its_ends_and_azimuth_goes_round():
    """Beyond the values that were seen nothing grows; a turn more is the same place."""
    told = {"kind": "curve", "name": "el_deg", "low": 0.5, "high": 1.0, "order": 4}
    inside, beyond = (values(told, Circumstances(np.zeros(1), np.array([e]))) for e in (1.0, 1.4))
    np.testing.assert_array_equal(inside, beyond)
    told |= {"name": "az_deg", "low": 1.0, "high": 5.0}
    one, other = (
        values(told, Circumstances(np.array([a]), np.zeros(1))) for a in (2.0, 2 - 4 * np.pi)
    )
    np.testing.assert_allclose(one, other, atol=1e-12)


def test_a_soft_edge_comes_back_and_knows_whole_turns():
    """Between columns of azimuth it steps; 350 deg is -10 deg where the cable was counted so."""
    rng = np.random.default_rng(1)
    width = np.radians(5)
    share = np.sort(rng.uniform(size=(36, 92)), axis=1).round(2)
    share[:, :30], share[:, 70:] = 0.0, 1.0
    edge = FreeEdge((-1.5, 1.5), (0.5, 0.9))
    one = jump_above(edge, SoftEdge(-18 * width, width, share))
    back = effect_of(one.id, there_and_back(one.member))
    az, el = rng.uniform(-1.5, 1.5, 500), rng.uniform(0, 1.5, 500)
    inside, turned = Circumstances(az, el), Circumstances(az + 2 * np.pi, el)

    np.testing.assert_array_equal(back.columns(inside)[1], one.columns(inside)[1])
    np.testing.assert_allclose(back.columns(turned)[1], one.columns(inside)[1])
    assert 0 < np.median(one.columns(inside)[1]) < 1


def test_an_edge_of_an_axis_comes_back_below_zero_too():
    """Y goes from -90 deg on: the levels of its soft edges are counted from the lowest."""
    share = np.tile(np.linspace(0, 1, 181), (36, 1))
    edge, soft = FreeEdge((-1.5, 1.5), (-0.5, 0.4)), SoftEdge(-np.pi / 2, np.radians(5), share, -90)
    at = Circumstances(np.zeros(3), np.radians([-89.5, 0.5, 89.5]))
    for axis, size in (("first", np.cos(at.el)), ("second", 1.0)):
        back = effect_of("subreflector_jump", there_and_back(jump_above(edge, soft, axis).member))
        moved, still = back.columns(at)[:: 1 if axis == "first" else -1]

        np.testing.assert_allclose(moved[:, 0], size * np.array([1, 91, 180]) / 180)
        assert not still.any()


@pytest.mark.parametrize(
    ("identity", "member", "said"),
    [
        ("nothing", {}, "no effect is called 'nothing'"),
        ("skew", {"k": 2}, "no family"),
        ("azimuth_track", {"j": 2}, "tells no member"),
        ("tilt", {"coefficient": 5}, "tells no member"),
        ("unknown", {"bumps": {"kind": "hills"}}, "tells no member"),
        ("unknown", FIELD | {"bumps": {"kind": "hills"}}, "no field is made of 'hills'"),
        ("unknown", FIELD | {"bumps": {"kind": "sky", "width_rad": 1e-9}}, "more bumps than"),
        (
            "subreflector_jump",
            {
                "edge_az_rad": [0.0],
                "edge_el_rad": [1.0],
                "share": {"start_rad": 0.0, "width_rad": 0.1, "levels": 10**12, "rows": [[0]]},
            },
            "an edge of 1000000000000 levels",
        ),
        ("subreflector_jump", {"axis": "third", "above_el_rad": 1.0}, "no axis is called 'third'"),
    ],
)
def test_a_member_that_is_none_is_refused(identity, member, said):
    """One line says which effect it is about."""
    with pytest.raises(BadInput, match=said):
        effect_of(identity, member)


@pytest.mark.parametrize(
    ("mount", "names"),
    [("equatorial", {"offset_xha", "offset_dec"}), ("xy-ns", {"offset_xx", "offset_y"})],
)
def test_a_step_keeps_the_names_of_its_mount(mount, names):
    """What a file holds of an effect is said in the words of the axes that it acts on."""
    from pyport.effects import catalogue

    at = replace(AT, mount=KINDS_OF_MOUNTS[mount])
    for one in catalogue(at.mount)["epoch_offset"].variants(at):
        kept = frozen(one, at)
        assert {each.name.partition("[")[0] for each in kept.coefficients} == names

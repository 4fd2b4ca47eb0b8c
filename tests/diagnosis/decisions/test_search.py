"""The search: what may join, lead, be exchanged, stand or give way to a field."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.decisions.stubs import beside, candidate, problem_with, step, trial
from effects.sky import campaign, replaced
from scipy.stats import chi2

from pyport.angles import ARCSEC, DEG
from pyport.diagnosis import case, diagnose
from pyport.diagnosis.candidates import Blocks
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.naming import classes, remarks
from pyport.diagnosis.naming.noise_remarks import NoiseRemarks
from pyport.diagnosis.searching import (
    changes,
    confirmed_changes,
    confirming,
    contenders,
    instead,
    search,
    settling,
    winner,
)
from pyport.diagnosis.searching.confirmed_changes import Changes
from pyport.diagnosis.searching.contenders import Contender
from pyport.diagnosis.searching.turns import Outcome, Step, family_p_value, gain_needed
from pyport.diagnosis.trial import at_best
from pyport.effects import CATALOGUE
from pyport.effects.circumstances import Circumstances
from pyport.effects.empirical.epochs import epoch_step
from pyport.noise.covariance import Covariance
from pyport.noise.estimation.frame import Frame
from pyport.noise.series import Departures, Noise
from pyport.recordings.schema import Stack

QUIET = lambda _: None  # noqa: E731
WEIGHED = SimpleNamespace(covariance=None)


def won(effect="refraction", evidence=20.0, **changes):
    """Return a contender without anything to refine."""
    one = trial(effect, evidence, **changes)
    return Contender(one, problem_with(part=lambda _: None), Chosen(one.candidate, one.scope), 0.0)


def outcome(*steps, p_value=0.5, last=(), **more):
    """Return the end of a search with some turns in it."""
    weighed = SimpleNamespace(
        evidence=SimpleNamespace(beside=lambda *_, **__: beside()), covariance=None
    )
    problem = problem_with(part=lambda _: None, expanded=lambda _: None, **more)
    return Outcome(problem, tuple(one.chosen for one in steps), steps, weighed, p_value, last)


def walked(monkeypatch, start, p_value, answers):
    """Return what `_walk` asked of a turn, and its end; `answers` are the winners, then None."""
    asked, left = [], list(answers)

    def winner_of(_setup, _weighed, chosen, _trials, least, **more):
        asked.append(SimpleNamespace(chosen=chosen, least=least, **more))
        return left.pop(0) if left else None

    monkeypatch.setattr(search, "trials_of", lambda *_: [])
    monkeypatch.setattr(search, "Changes", lambda *_: SimpleNamespace(nearest=lambda: None))
    monkeypatch.setattr(search, "family_p_value", lambda _: p_value)
    monkeypatch.setattr(search, "winner_of", winner_of)
    monkeypatch.setattr(search, "joined", lambda _, chosen, new: (*chosen, new))
    monkeypatch.setattr(search, "_settled", lambda now: now)
    monkeypatch.setattr(search, "_exchanged", lambda now, *_: now)
    return asked, search._walk(start, QUIET)


@pytest.mark.parametrize(("p_value", "sure", "told"), [(0.4, 10.0, np.exp(-5)), (1e-9, 10.0, 1e-9)])
def test_odds_bound_the_chance_of_noise(monkeypatch, p_value, sure, told):
    """Noise alone reaches a Bayes factor in no more than one over it of all cases."""
    _, end = walked(monkeypatch, outcome(), p_value, [replace(won(), sure=sure)])

    assert end.steps[0].p_value == pytest.approx(told)
    assert end.p_value == pytest.approx(told)


ACTS_IN = {"collimation": {False}, "refraction": {True}, "tilt": {False, True}}


@pytest.mark.parametrize(
    ("gain", "name", "least"),
    [
        (1000.0, "collimation", 20.0),
        (5000.0, "collimation", 100.0),
        (1000.0, "tilt", 20.0),
        (1000.0, "refraction", 6.0),
    ],
)
def test_a_further_finding_must_exceed_what_a_strong_one_leaves(monkeypatch, gain, name, least):
    """Two per cent of the strongest gain in offsets of an axis that both act in."""
    strong, weak = (trial(one, gain=some) for one, some in (("collimation", gain), ("tilt", 300.0)))
    start = outcome(step(strong), step(weak), axes_of=lambda one: frozenset(ACTS_IN[one.effect.id]))
    asked, _ = walked(monkeypatch, start, 0.5, [])

    assert asked[0].least(start.problem, candidate(name)) == pytest.approx(least)


def test_a_search_ends_at_eight_findings(monkeypatch):
    """However much is left."""
    _, end = walked(monkeypatch, outcome(), 1e-9, [won() for _ in range(20)])

    assert len(end.steps) == 8


QUIET_NOISE = NoiseRemarks([], [], [], [], [])


def warned(at, turns=0):
    """Return what is warned of after so many turns, of fits in which nothing is wrong."""
    fit = SimpleNamespace(
        solution=SimpleNamespace(
            known=np.ones(1, bool), condition=1.0, covariance=np.eye(1), rank=1
        ),
        choices=(),
    )
    return remarks.warnings(
        SimpleNamespace(
            problem=SimpleNamespace(
                residual=np.zeros(100),
                base=(),
                stack=Stack(np.arange(40), np.zeros(40, bool), np.zeros(40)),
                recordings=SimpleNamespace(at=at, meta={}),
                precision=lambda _: np.zeros(1),
            ),
            before=fit,
            after=fit,
            findings=(),
            steps=(0,) * turns,
            left=lambda _: np.ones(40),
            share=np.ones(40),
            weighed=SimpleNamespace(used=np.ones(40, bool)),
            too_few=None,
        ),
        QUIET_NOISE,
    )


@pytest.mark.parametrize(("turns", "said"), [(8, True), (7, False), (5, False)])
def test_a_search_that_stopped_there_says_so(turns, said):
    """Eight findings are not the end."""
    found = warned(campaign(40), turns)

    assert any("did not come to its end" in one for one in found) == said


def test_conditions_that_are_too_many_are_named():
    """Of six that are known and six sensors ten are tried, and two sensors told."""
    noise = np.random.default_rng(2).normal(size=(6, 40))
    more = replaced(campaign(40), **{f"sensor{n}": one for n, one in enumerate(noise)})

    assert warned(campaign(40)) == []
    (said,) = warned(more)
    assert said.startswith("10 conditions at most")
    assert said.count("sensor") == 2


@pytest.mark.parametrize(
    ("p_value", "clear"), [(0.0105, True), (0.0095, False), (0.006, False), (0.015, True)]
)
def test_silence_is_no_all_clear_where_something_is_left(monkeypatch, p_value, clear):
    """Up to a p-value of one in a hundred what is left does not look like the noise."""
    monkeypatch.setattr(remarks, "_hides", lambda *_: "")
    done = SimpleNamespace(detection_limits={}, too_few=None, p_value=p_value, nearest=None)

    assert remarks.nothing(done, QUIET_NOISE).startswith("Nothing is missing") == clear


def test_the_nearest_change_is_said_with_its_odds(monkeypatch):
    """Where nothing is found, and among what was dropped; not where the same was found."""
    monkeypatch.setattr(remarks, "_hides", lambda *_: "")
    one = won("epoch_tilt", 4.0)
    near = diagnose._nearest(replace(outcome(), nearest=replace(one, sure=4.0)))
    done = SimpleNamespace(detection_limits={}, too_few=None, p_value=0.5, nearest=near)

    assert near.reason.startswith("odds of 7.4 to 1")
    assert near.reason.endswith("20 are needed")
    assert "Nothing is certain to be missing; the nearest is epoch_tilt" in remarks.nothing(
        done, QUIET_NOISE
    )
    found = outcome(step(trial("epoch_tilt")))
    assert diagnose._nearest(replace(found, nearest=replace(one, sure=4.0))) is None
    assert diagnose._nearest(outcome()) is None


@pytest.mark.parametrize(
    ("sure", "stands"), [(6.2, True), (5.8, False), (3.5, False), (11.0, True)]
)
def test_what_stands_needs_odds_of_twenty_to_one(monkeypatch, sure, stands):
    """The noise, estimated with it and without, does as well: dropped."""
    monkeypatch.setattr(search, "_standing_of", lambda *_: sure)
    monkeypatch.setattr(search, "weigh", lambda *_: None)
    end = search._standing(outcome(step(trial("epoch_tilt"))), QUIET)

    assert bool(end.chosen) == stands


def test_the_weakest_is_dropped_first(monkeypatch):
    """What is left is asked again."""
    one, other = step(trial("epoch_tilt")), step(trial("drift"))
    sure = lambda now, each: {1: 9.0, 2: 3.0 if each is other.chosen else 5.0}[len(now.chosen)]  # noqa: E731
    monkeypatch.setattr(search, "_standing_of", sure)
    monkeypatch.setattr(search, "weigh", lambda *_: None)
    end = search._standing(outcome(one, other), QUIET)

    assert end.chosen == (one.chosen,)


@pytest.mark.parametrize(
    ("ahead", "exchanged"), [(6.5, True), (5.5, False), (3.5, False), (11.0, True)]
)
def test_a_choice_is_exchanged_for_one_twenty_times_likelier(monkeypatch, ahead, exchanged):
    """Beside the later ones, another effect must beat it by six."""
    first, last = step(trial("sag_sine")), step(trial("tilt"))
    better = won("refraction", 30.0 + ahead)

    def winner_of(_setup, _weighed, _others, _trials, least, **_):
        return better if better.trial.evidence > least(None, better.chosen.candidate) else None

    monkeypatch.setattr(search, "trials_of", lambda *_: [])
    monkeypatch.setattr(search, "alone", lambda *_: trial("sag_sine", 30.0))
    monkeypatch.setattr(search, "winner_of", winner_of)
    monkeypatch.setattr(search, "_settled", lambda now: now)
    end = search._exchanged(outcome(first, last), QUIET)

    assert (end.chosen[0].candidate.effect.id == "refraction") == exchanged


@pytest.mark.parametrize(("fits", "wrong"), [(True, set()), (False, {"annual_aberration"})])
def test_a_size_that_physics_fixes_is_tested_in_the_end(monkeypatch, fits, wrong):
    """An effect that does not have it is banned, and the search made again."""
    value = 1.0 if fits else 1.7
    of = trial("annual_aberration")
    known = of.candidate.effect.coefficients[0]
    shown = trial(
        "annual_aberration",
        value=value * known.expected * known.scale,
        sigma=0.01 * known.expected * known.scale,
    )
    monkeypatch.setattr(search, "alone", lambda *_: shown)

    assert set(search._wrong_sizes(outcome(step(of)))) == wrong


def test_a_wrong_size_starts_the_search_again(monkeypatch):
    """Without the effect that does not have the size of physics."""
    banned, wrong = [], [frozenset({"annual_aberration"}), frozenset()]
    monkeypatch.setattr(search, "weigh", lambda *_: None)
    monkeypatch.setattr(
        search, "_searched", lambda start, _: banned.append(start.banned) or outcome()
    )
    monkeypatch.setattr(search, "_wrong_sizes", lambda _: wrong.pop(0))
    monkeypatch.setattr(search, "_standing", lambda now, _: now)
    monkeypatch.setattr(search, "_walk", lambda now, *_: now)
    search.search(problem_with(), QUIET)

    assert banned == [frozenset(), frozenset({"annual_aberration"})]


def test_what_is_banned_stays_so_where_a_search_goes_on(monkeypatch):
    """A search that is resumed does not find again what the first one refused for its size."""
    start = replace(outcome(), banned=frozenset({"annual_aberration"}))
    asked, end = walked(monkeypatch, start, 0.5, [])

    assert asked[0].banned == end.banned == {"annual_aberration"}


def test_what_is_found_after_a_drop_has_to_stand_too(monkeypatch):
    """The search goes on without what was dropped, and comes upon it again."""
    one = step(trial("drift"))
    monkeypatch.setattr(search, "_searched", lambda *_: outcome(one))
    monkeypatch.setattr(search, "_walk", lambda *_: outcome(one))
    monkeypatch.setattr(search, "_wrong_sizes", lambda _: frozenset())
    monkeypatch.setattr(search, "_standing_of", lambda *_: 5.0)
    monkeypatch.setattr(search, "weigh", lambda *_: None)

    assert search.search(problem_with(), QUIET).chosen == ()


def fixed(evidence, times):
    """Return a trial of aberration, so many times as large as physics says."""
    of = candidate("annual_aberration").effect.coefficients[0]
    size = of.expected * of.scale
    return trial("annual_aberration", evidence, value=times * size, sigma=0.01 * size)


@pytest.mark.parametrize(
    ("evidence", "times", "leads"),
    [
        (40.5, 1.5, True),
        (39.5, 1.5, False),
        (36.0, 1.5, False),
        (48.0, 1.5, True),
        (90.0, 2.5, False),
        (25.0, 1.0, False),
    ],
)
def test_a_wrong_size_leads_only_by_far(evidence, times, leads):
    """By ten beside the best other, which has thirty, and bent by no more than twice."""
    found = winner._worth(
        problem_with(), [trial("sag_sine", 30.0), fixed(evidence, times)], lambda *_: 0.0, ()
    )

    assert (found[0].candidate.effect.id == "annual_aberration") == leads


def test_the_search_asks_no_change_no_shape_and_nothing_banned():
    """Changes with time are confirmed apart; least is what evidence must exceed."""
    trials = [
        trial("refraction", 30.0),
        trial("epoch_tilt", 90.0),
        trial("skew", 20.0),
        trial("sag_sine", 9.0),
    ]
    found = winner._worth(problem_with(), trials, lambda *_: 10.0, ("skew",))

    assert [one.candidate.effect.id for one in found] == ["refraction"]


@pytest.mark.parametrize(
    ("gained", "gain", "was", "good"),
    [
        (31.0, 100.0, 500.0, True),
        (29.0, 100.0, 500.0, False),
        (16.0, 100.0, 500.0, False),
        (59.0, 100.0, 500.0, True),
        # No effect gains more on unseen data than there was.
        (31.0, 1000.0, 100.0, True),
        (29.0, 1000.0, 100.0, False),
    ],
)
def test_three_tenths_of_the_gain_must_show_on_unseen_data(monkeypatch, gained, gain, was, good):
    """Of what it gains in the fit."""
    misfit = {"before": was, "after": was - gained}
    monkeypatch.setattr(winner, "folds", lambda *_: None)
    monkeypatch.setattr(winner, "unseen_misfit", lambda _s, _w, which, _p: misfit[which])

    assert winner.predicts(None, None, "before", "after", gain) == good


def winning(
    monkeypatch,
    lasting=(),
    moved=(),
    drives=(),
    sure=99.0,
    unseen=lambda _: True,
    **options,
):
    """Return what wins a turn among lasting effects and changes."""

    def confirmed(above):
        return [one for one in moved if one.trial.gain > above]

    options.setdefault("changes", SimpleNamespace(confirmed=confirmed))
    monkeypatch.setattr(winner, "lasting_effects", lambda *_: list(lasting))
    monkeypatch.setattr(winner, "_of_drives", lambda *_: list(drives))
    monkeypatch.setattr(
        winner, "evidence_anew", lambda one, _: sure(one) if callable(sure) else sure
    )
    monkeypatch.setattr(winner, "joined", lambda _, chosen, new: (*chosen, new))
    monkeypatch.setattr(
        winner, "predicts", lambda _s, _w, _b, after, _g: unseen(after[-1].candidate.effect.id)
    )
    return winner.winner_of(
        problem_with(), WEIGHED, (), (), lambda *_: 0.0, beside=None, banned=(), **options
    )


def changed(above=-np.inf):
    """Return the changes of a turn that convince, and promise more than something."""
    return winner._convincing(Changes(problem_with(), None, (), ()).confirmed(above))


def turn(*args, **options):
    """Return who wins a turn, None where nobody does."""
    found = winning(*args, **options)
    return found and found.trial.candidate.effect.id


NAMES = ("refraction", "skew", "tilt", "sag_sine", "sag_cosine", "collimation")
RANKED = [won(name, 50.0 - n) for n, name in enumerate(NAMES)]


@pytest.mark.parametrize(("failing", "wins"), [(0, 0), (1, 1), (3, 3), (4, None)])
def test_the_next_best_takes_its_turn_on_unseen_data(monkeypatch, failing, wins):
    """Four may fail; the fifth is no candidate."""
    bad = NAMES[:failing]
    found = turn(monkeypatch, RANKED, unseen=lambda one: one not in bad)

    assert found == (None if wins is None else NAMES[wins])


@pytest.mark.parametrize(
    ("forth", "back", "scope", "kept"),
    [
        (0.995, 0.995, "all", 1),
        (0.985, 0.995, "all", 2),
        (0.995, 0.985, "all", 2),
        (0.995, 0.995, "antenna", 2),
    ],
)
def test_of_one_curve_the_first_stands_for_all(forth, back, scope, kept):
    """Where each draws what the other does to a squared cosine of 0.99, in one scope."""
    first, second = trial("refraction", 20.0), trial("wet_refraction", 19.0, scope=scope)
    shared = SimpleNamespace(share=lambda one, _: forth if one is first else back)

    assert classes.distinct(shared, [first, second], 4) == [first, second][:kept]


def test_four_curves_are_tried_whatever_their_formulas(monkeypatch):
    """A second formula of one curve leaves room for another curve."""
    monkeypatch.setattr(
        winner,
        "refined",
        lambda of, _w, _c, one: Contender(one, of, Chosen(one.candidate, "all"), 0),
    )
    alike = {NAMES[0], NAMES[1]}
    same = SimpleNamespace(
        share=lambda *some: float({one.candidate.effect.id for one in some} <= alike)
    )
    trials = [one.trial for one in RANKED]
    found = winner.lasting_effects(problem_with(), WEIGHED, (), trials, (), lambda *_: 0.0, same)

    assert [one.trial.candidate.effect.id for one in found] == [NAMES[n] for n in (0, 2, 3, 4)]


@pytest.mark.parametrize(
    ("evidence", "scope", "antennas", "less"),
    [
        (20.0, "all", 1, 2 * np.log(2)),
        (18.0, "all", 1, 2 * np.log(1 + np.exp(-1))),
        (20.1, "all", 1, 0.0),
        (20.0, "session", 1, 0.0),
        (20.0, "all", 2, 0.0),
    ],
)
def test_one_of_several_alike_is_likelier_than_that_one(
    monkeypatch, evidence, scope, antennas, less
):
    """It pays the less for its choice; those that lead it, or of another scope, are no help."""
    monkeypatch.setattr(
        winner,
        "refined",
        lambda _s, _w, _c, one: Contender(one, None, Chosen(one.candidate, "all"), 3.0),
    )
    monkeypatch.setattr(winner.classes, "distinct", lambda _, trials, __: list(trials))
    own, other = trial("refraction", 20.0), trial("skew", evidence, scope=scope)
    given = problem_with(blocks=SimpleNamespace(antennas=antennas))
    found = winner.lasting_effects(given, WEIGHED, (), [own, other], (), lambda *_: 0.0, None)

    (mine,) = (one for one in found if one.trial is own)
    assert mine.price == pytest.approx(3.0 - less)


@pytest.mark.parametrize(("sure", "wins"), [(6.5, True), (5.5, False), (3.5, False), (11.0, True)])
def test_what_joins_is_confirmed(monkeypatch, sure, wins):
    """By odds of twenty to one."""
    found = turn(monkeypatch, RANKED[:1], sure=sure)

    assert found == ("refraction" if wins else None)


@pytest.mark.parametrize(("odds", "wins"), [(6.5, True), (5.5, False), (3.5, False), (11.0, True)])
def test_beside_a_change_only_confirmed_effects_compete(monkeypatch, odds, wins):
    """A lasting effect that the noise can do as well gives way to a change."""
    found = turn(monkeypatch, RANKED[:1], [won("epoch_tilt", 10.0)], sure=odds)

    assert found == ("refraction" if wins else "epoch_tilt")


def test_the_confirmed_evidence_counts_beside_a_change(monkeypatch):
    """Of a lasting effect the better of both kinds of evidence."""
    found = turn(monkeypatch, [won("refraction", 7.0)], [won("epoch_tilt", 10.0)], sure=12.0)

    assert found == "refraction"


@pytest.mark.parametrize(("evidence", "wins"), [(5.5, False), (6.5, True)])
@pytest.mark.parametrize("moved", [[], [won("epoch_tilt", -9.0, gain=90.0)]])
def test_what_lasts_needs_odds_of_twenty_to_one_in_its_turn_too(monkeypatch, moved, evidence, wins):
    """However much likelier noise estimated anew makes it."""
    found = turn(monkeypatch, [won("refraction", evidence)], moved, sure=50.0)

    assert (found == "refraction") == wins


@pytest.mark.parametrize(
    ("name", "like_both", "like_others", "found"),
    [
        ("refraction", 17.0, 14.0, 5.5),
        ("refraction", 17.0, 19.0, 8.0),
        ("refraction", 15.0, 19.0, 5.0),
        ("epoch_tilt", 17.0, 14.0, 7.0),
    ],
)
def test_what_lasts_stands_beside_the_tails_of_either_world(
    monkeypatch, name, like_both, like_others, found
):
    """The mean counts; of a change they are what it looks like, and what fails is asked once."""
    asked = []

    def gained(_, others, __, *, like):
        asked.append(like)
        return like_others if like == others else like_both

    monkeypatch.setattr(confirming, "_gained", gained)
    monkeypatch.setattr(confirming, "among", lambda *_: 7.0)
    others = (Chosen(candidate("skew"), "all"),)
    one = Chosen(candidate(name), "all")

    assert confirming.confirmed(problem_with(), others, one, 3.0) == pytest.approx(found)
    assert len(asked) == (2 if like_both - 10 > 6 and name == "refraction" else 1)


def test_what_cannot_stand_is_not_asked_for_again(monkeypatch):
    """Noise estimated anew takes long."""
    asked = []
    turn(monkeypatch, [won("refraction", 5.5)], sure=lambda one: asked.append(one) or 50.0)

    assert not asked


@pytest.mark.parametrize(
    ("promise", "unseen", "wins"),
    [(30.0, True, "epoch_tilt"), (15.0, True, "refraction"), (15.0, False, "epoch_tilt")],
)
def test_a_change_that_promises_less_waits(monkeypatch, promise, unseen, wins):
    """Until the lasting effect that gains more has failed."""
    lasting, moved = [won("refraction", 20.0)], [won("epoch_tilt", 25.0, gain=promise)]
    found = turn(monkeypatch, lasting, moved, sure=22.0, unseen=lambda _: unseen)

    assert found == wins


def test_what_the_noise_does_as_well_does_not_crowd_out_a_change(monkeypatch):
    """Four at most are tried."""
    moved = [won("epoch_tilt", 20.0, gain=90.0)]

    assert turn(monkeypatch, RANKED, moved, sure=5.0) == "epoch_tilt"


def test_changes_are_looked_for_where_they_are_asked_for(monkeypatch):
    """What takes the place of a lasting effect lasts."""
    assert turn(monkeypatch, (), [won("epoch_tilt")]) == "epoch_tilt"
    assert turn(monkeypatch, (), [won("epoch_tilt")], changes=None) is None


@pytest.mark.parametrize(("passes", "wins"), [(True, "refraction"), (False, "epoch_tilt")])
def test_a_change_that_promises_less_waits_until_the_lasting_effect_has_failed(
    monkeypatch, passes, wins
):
    """On data left out, for instance."""
    lasting, moved = [won("refraction", 90.0)], [won("epoch_tilt", 60.0, gain=60.0)]

    assert turn(monkeypatch, lasting, moved, unseen=lambda _: passes) == wins


@pytest.mark.parametrize(
    ("sure", "least", "banned", "wins"),
    [
        (20.0, 0.0, (), True),
        (5.0, 0.0, (), False),
        (20.0, 25.0, (), False),
        (20.0, 0.0, ("azimuth_harmonics",), False),
    ],
)
def test_a_short_wave_is_looked_for_by_itself(monkeypatch, sure, least, banned, wins):
    """No trial has its period; it must beat what the noise can do, and the least."""
    wave = won("azimuth_harmonics", 20.0)
    monkeypatch.setattr(winner.drive_waves, "proposed", lambda *_: wave.chosen)
    monkeypatch.setattr(winner, "waves_of", lambda *_: [wave])
    drives = winner._of_drives(problem_with(), WEIGHED, (), lambda *_: least, banned)
    found = turn(monkeypatch, drives=drives, sure=sure)

    assert (found is not None) == wins


@pytest.mark.parametrize(
    ("sure", "found"), [(6.5, True), (5.5, False), (3.5, False), (11.0, True), (-1.0, False)]
)
def test_a_change_is_confirmed_by_odds_of_twenty_to_one(monkeypatch, sure, found):
    """Its evidence is then that of the worlds with it and without."""
    monkeypatch.setattr(
        confirmed_changes, "proposed", lambda *_: (None, [trial("epoch_tilt", 40.0)])
    )
    monkeypatch.setattr(confirmed_changes, "refined", lambda *_: won("epoch_tilt", 40.0))
    monkeypatch.setattr(confirmed_changes, "evidence_anew", lambda *_: sure)
    monkeypatch.setattr(confirmed_changes.oscillations, "proposed", lambda *_: None)

    assert [one.trial.evidence for one in changed()] == ([sure] if found else [])


@pytest.mark.parametrize(
    ("sure", "near"), [((0.5, 5.0), 1), ((0.5, -0.5), 0), ((-0.5, -3.0), None), ((5.5, 6.5), 0)]
)
def test_the_nearest_change_is_likelier_than_not(monkeypatch, sure, near):
    """The best of those that do not convince."""
    some = [won("epoch_tilt", one) for one in sure]
    monkeypatch.setattr(Changes, "confirmed", lambda *_: some)
    found = Changes(problem_with(), None, (), ()).nearest()

    assert found is (None if near is None else some[near])


@pytest.mark.parametrize(
    ("evidence", "weighed"), [(6.6, True), (5.4, False), (3.5, False), (11.0, True)]
)
def test_a_change_is_weighed_from_odds_of_twenty_to_one(monkeypatch, evidence, weighed):
    """Beside noise that holds still, at its best moment."""
    monkeypatch.setattr(
        confirmed_changes, "proposed", lambda *_: (None, [trial("epoch_tilt", 1.0)])
    )
    monkeypatch.setattr(confirmed_changes, "refined", lambda *_: won("epoch_tilt", evidence))
    monkeypatch.setattr(confirmed_changes, "evidence_anew", lambda *_: 20.0)
    monkeypatch.setattr(confirmed_changes.oscillations, "proposed", lambda *_: None)

    assert bool(changed()) == weighed


def test_a_change_is_told_from_the_changes_that_it_competed_with(monkeypatch):
    """By the evidence that the noise leaves them: its turn holds them before what was tried."""
    best, other = won("epoch_sag", 25.0), won("epoch_offset", 23.0)
    wins = winner._first(None, (), [other, best], [])

    assert wins.trial is best.trial
    assert wins.rivals == (other.trial,)
    _, end = walked(monkeypatch, outcome(), 0.5, [wins])
    assert end.steps[0].trials[0] is other.trial


def test_every_kind_of_change_that_promises_something_is_weighed(monkeypatch):
    """What promises most may be what the noise does as well."""
    promised = {"drift": 12.0, "epoch_sag": 50.0, "epoch_tilt": 3.0, "epoch_offset": 30.0}
    kinds = [trial(name, 40.0) for name in promised]
    monkeypatch.setattr(confirmed_changes, "proposed", lambda *_: (None, kinds))
    monkeypatch.setattr(
        confirmed_changes,
        "refined",
        lambda *given: won(given[3].candidate.effect.id, promised[given[3].candidate.effect.id]),
    )
    monkeypatch.setattr(confirmed_changes, "evidence_anew", lambda *_: 20.0)
    monkeypatch.setattr(confirmed_changes.oscillations, "proposed", lambda *_: None)
    found = changed()

    assert {one.chosen.candidate.effect.id for one in found} == {
        "drift",
        "epoch_sag",
        "epoch_offset",
    }


@pytest.mark.parametrize(("above", "found"), [(39.0, 1), (41.0, 0)])
def test_only_changes_that_promise_enough_are_confirmed(monkeypatch, above, found):
    """An oscillation is asked for as much."""
    monkeypatch.setattr(
        confirmed_changes, "proposed", lambda *_: (None, [trial("epoch_tilt", 40.0)])
    )
    monkeypatch.setattr(confirmed_changes, "refined", lambda *_: won("epoch_tilt", 40.0))
    monkeypatch.setattr(confirmed_changes, "evidence_anew", lambda *_: 20.0)
    asked = []
    monkeypatch.setattr(
        confirmed_changes.oscillations, "proposed", lambda *given: asked.append(given[-1])
    )

    assert len(changed(above)) == found
    assert asked == [above]


@pytest.mark.parametrize(
    ("tilts", "clocks", "asked"),
    [(20.0, 40.0, 2), (5.0, 40.0, 1), (20.0, 41.0, 2), (20.0, 39.0, 1)],
)
def test_a_clock_changes_where_a_tilt_does(monkeypatch, tilts, clocks, asked):
    """It is a tilt with a zero: beside nights that lean a little it would be claimed by itself.

    And it explains as much as the tilt beside noise that holds still, else it is the zero alone.
    """
    still = {"epoch_clock": clocks, "epoch_tilt": 40.0}
    kinds = [trial(name, 40.0) for name in ("epoch_clock", "epoch_tilt")]
    monkeypatch.setattr(confirmed_changes, "proposed", lambda *_: (None, kinds))
    monkeypatch.setattr(
        confirmed_changes,
        "refined",
        lambda *given: won(given[3].candidate.effect.id, still[given[3].candidate.effect.id]),
    )
    confirmed = []

    def sure(one, _):
        name = one.chosen.candidate.effect.id
        confirmed.append(name)
        return tilts if name == "epoch_tilt" else 30.0

    monkeypatch.setattr(confirmed_changes, "evidence_anew", sure)
    monkeypatch.setattr(confirmed_changes.oscillations, "proposed", lambda *_: None)
    changed()

    assert confirmed == ["epoch_tilt", "epoch_clock"][:asked]


def test_a_confirmation_pays_for_its_choice(monkeypatch):
    """For the moment that was refined, and for the members of its family."""
    asked = []
    monkeypatch.setattr(contenders, "confirmed", lambda *given: asked.append(given[-1]) or 0.0)
    monkeypatch.setattr(contenders, "joined", lambda _, chosen, new: (*chosen, new))
    of = candidate("epoch_tilt", choices=7)
    refined = (problem_with(), Chosen(of, "all"), 1.0, 3.0)
    monkeypatch.setattr(contenders, "refine", lambda *_: refined)
    one = contenders.refined(problem_with(), None, (), trial("epoch_tilt", of=of))
    contenders.evidence_anew(one, ())

    assert asked == [pytest.approx(3.0 + 2 * np.log(7))]


def test_a_choice_pays_as_much_at_the_end(monkeypatch):
    """As when it joined, whatever its evidence was then."""
    asked = []
    monkeypatch.setattr(search, "confirmed", lambda *given: asked.append(given[-1]) or 0.0)
    one = replace(step(trial("epoch_tilt", 30.0, gain=30.0)), price=5.5)
    search._standing_of(outcome(one), one.chosen)

    assert asked == [5.5]


@pytest.mark.parametrize(
    ("antennas", "scope", "anew"),
    [
        (1, "all", 50.0),
        (3, "all", 50.0),
        (4, "all", 20 - 24 + 8 * np.log(4) - 2 * np.log(6)),
        (4, "antenna", 20 - 2 * np.log(6)),
    ],
)
def test_in_an_array_the_noise_of_the_turn_counts(monkeypatch, antennas, scope, anew):
    """Its scale is known from so many deviations; noise estimated anew shares nothing."""
    monkeypatch.setattr(contenders, "joined", lambda _, chosen, new: (*chosen, new))
    monkeypatch.setattr(contenders, "confirmed", lambda *_: 50.0)
    blocks, some = SimpleNamespace(antennas=antennas), [candidate(name) for name in NAMES]
    one = won("refraction", 20.0, gain=24.0, noise_dof=8, scope=scope)
    one = replace(one, problem=problem_with(blocks=blocks, candidates=some))

    assert contenders.evidence_anew(one, ()) == pytest.approx(anew, abs=1e-3)


def test_an_effect_pays_for_being_one_of_many():
    """A change for the kinds of change, a source for itself too, any other for all lasting.

    A clock for all changes; no change pays for it.
    """
    names = ("epoch_tilt", "drift", "source_position", *NAMES, "epoch_clock")
    some = tuple(candidate(name) for name in names)
    problem = problem_with(candidates=some)

    assert confirming.among(problem, some[0].effect) == pytest.approx(2 * np.log(2))
    assert confirming.among(problem, some[2].effect) == pytest.approx(2 * np.log(3))
    assert confirming.among(problem, some[3].effect) == pytest.approx(2 * np.log(len(NAMES)))
    assert confirming.among(problem, some[-1].effect) == pytest.approx(2 * np.log(3))


@pytest.mark.parametrize(
    ("others", "like", "departing", "turns"),
    [(0, 1, True, 2), (0, 1, False, 1), (1, 1, True, 1), (1, 0, True, 1)],
)
def test_what_an_effect_leaves_behind_takes_more_than_one_turn(
    monkeypatch, others, like, departing, turns
):
    """It passes from departures to drift and back; all else is nearly what it is alike to."""
    asked = []
    monkeypatch.setattr(confirming, "noise", lambda *_, **__: None)
    monkeypatch.setattr(confirming, "estimate", lambda *_, turns, **__: asked.append(turns))
    frame = Frame((), (), (), None)
    problem = problem_with(frame=frame, residual=None, expanded=lambda _: None)
    some = [Chosen(candidate("skew"), "all")]
    confirming._noise_alike(problem, some[:others], some[:like], departing=departing)

    assert asked == [turns]


def test_departures_as_wide_as_the_scatter_are_half_as_probable():
    """The half-Cauchy prior of their standard deviation."""
    noise = SimpleNamespace(between=3.0, within=4.0)
    known = SimpleNamespace(noises=[noise], departures=[SimpleNamespace(sigma=5.0)])

    assert confirming._improbable(known) == pytest.approx(2 * np.log(2))


def test_evidence_beside_a_model_is_that_of_dense_algebra():
    """Restricted likelihood of white noise, and what a column adds to it."""
    rng = np.random.default_rng(0)
    model, own, value = rng.normal(size=(30, 2)), rng.normal(size=(30, 1)), rng.normal(size=30)
    plain = SimpleNamespace(
        whiten=lambda columns: columns / 2.0,
        log_determinant=30 * np.log(4.0),
        noises=[SimpleNamespace(between=2.0, within=0.0)],
        departures=[],
    )
    lack, gained = confirming._lack(plain, model, own, value, 0.0)
    basis = np.linalg.qr(model)[0]
    left = (value - basis @ (basis.T @ value)) / 2
    wanted = 30 * np.log(4) + np.linalg.slogdet(model.T @ model / 4)[1] + left @ left
    column = (own[:, 0] - basis @ (basis.T @ own[:, 0])) / 2

    assert lack == pytest.approx(wanted)
    assert gained < (column @ left) ** 2 / (column @ column)


def field(evidence, directions=1, *, of_time=False, of_two=False):
    """Return what a field is worth."""
    return SimpleNamespace(
        evidence=evidence,
        directions=np.ones((3, directions)),
        gain=1.0,
        field=SimpleNamespace(of_time=of_time, of_two=of_two),
    )


def left(monkeypatch, worths, now, turn=0, together=0.0, gain=0.0):
    """Return which names a field leaves that takes the place of others; None where none does."""

    def every(of_time):
        return [one for one in worths if one.field.of_time in of_time]

    case = {"problem": None, "weighed": None, "chosen": ()}
    ground = SimpleNamespace(worths=every, worth_of=lambda one: one, gain=lambda _: gain, **case)
    monkeypatch.setattr(instead, "Ground", lambda *_: ground)
    monkeypatch.setattr(instead, "boxes", lambda *_: [])
    monkeypatch.setattr(instead, "cycles", lambda *_: [])
    monkeypatch.setattr(instead, "sectors", lambda _: [])
    monkeypatch.setattr(instead, "weigh_model", lambda *_: None)
    monkeypatch.setattr(instead, "_evidence", lambda *_: together)
    monkeypatch.setattr(instead, "_with_field", lambda _, kept, __: kept)
    kept = instead.field_instead(now, turn)
    return kept if kept is None else [one.winner.candidate.effect.id for one in kept]


def taken(*args, **options):
    """Tell whether a field takes the place of names from some turn on."""
    return left(*args, **options) is not None


@pytest.mark.parametrize(
    ("evidence", "wins"), [(56.5, True), (55.5, False), (53.5, False), (61.0, True)]
)
def test_a_field_must_beat_all_names_by_six(monkeypatch, evidence, wins):
    """Names together have fifty."""
    now = outcome(step(trial()))

    assert taken(monkeypatch, [field(evidence)], now, together=50.0) == wins


@pytest.mark.parametrize(("evidence", "wins"), [(62.5, True), (61.5, False), (56.5, False)])
def test_a_surface_over_two_columns_must_beat_all_names_by_twelve(monkeypatch, evidence, wins):
    """A name that one column drives, drawn over two, would be six better by chance too often."""
    now = outcome(step(trial()))

    assert taken(monkeypatch, [field(evidence, of_two=True)], now, together=50.0) == wins
    assert taken(monkeypatch, [field(9.4, of_two=True)], outcome())


@pytest.mark.parametrize(
    ("evidence", "wins"), [(111.0, True), (109.0, False), (101.0, False), (131.0, True)]
)
def test_a_field_must_exceed_what_strong_names_leave(monkeypatch, evidence, wins):
    """Two per cent of their gain, three thousand: shapes are known to first order only."""
    now = outcome(step(trial()))

    assert taken(monkeypatch, [field(evidence)], now, together=50.0, gain=3000.0) == wins


@pytest.mark.parametrize(
    ("dropped", "after", "kept"),
    [
        ("unknown", 2.9, "resumed"),
        ("unknown", 3.1, "searched"),
        ("epoch_tilt", 2.9, "resumed without epoch_tilt"),
        ("epoch_tilt", 3.1, "searched"),
        ("refraction", 2.9, "searched"),
    ],
)
def test_names_get_back_the_place_of_what_was_dropped(monkeypatch, dropped, after, kept):
    """Of a field, or of a change, if data left out are predicted better without it."""
    one = settling.Dropped(dropped, "", "it does not pay")

    def resumed(now, _):
        return replace(now, p_value=" without ".join(["resumed", *now.banned]))

    monkeypatch.setattr(diagnose, "search", lambda *_: replace(outcome(), p_value="searched"))
    monkeypatch.setattr(diagnose, "resumed", resumed)
    monkeypatch.setattr(diagnose, "averaged", lambda now: now)
    monkeypatch.setattr(diagnose, "settled", lambda now: (now, (one,)))
    monkeypatch.setattr(diagnose, "folds", lambda *_: None)
    told = SimpleNamespace(rms=lambda: (3.0, after))
    monkeypatch.setattr(diagnose, "unseen", lambda *_: told)

    candidates = [trial(name).candidate for name in ("epoch_tilt", "refraction")]
    found, told = diagnose.searched(SimpleNamespace(candidates=candidates), lambda _: None)
    assert (found.p_value, told) == (kept, (one,))


@pytest.mark.parametrize(("of_time", "kept"), [(False, ["epoch_tilt"]), (True, [])])
def test_a_field_that_lasts_leaves_changes_with_time(monkeypatch, of_time, kept):
    """One in time stands in place of both."""
    now = outcome(*(step(trial(name)) for name in ("refraction", "epoch_tilt")))

    assert left(monkeypatch, [field(90.0, of_time=of_time)], now) == kept


def test_a_field_that_lasts_does_not_stand_in_place_of_a_change(monkeypatch):
    """However much it explains beside the noise that holds the change."""
    now = outcome(step(trial("epoch_tilt")))

    assert not taken(monkeypatch, [field(90.0)], now)


@pytest.mark.parametrize(("until", "kept"), [(np.inf, None), (2e9, [])])
def test_a_field_that_lasts_may_stand_in_place_of_what_came_back(monkeypatch, until, kept):
    """That was seen in some part of the sky, and may be what is wrong there."""
    effect = epoch_step(1e9, CATALOGUE["epoch_offset"], until)
    now = outcome(step(trial(of=replace(candidate("epoch_offset"), effect=effect))))

    assert left(monkeypatch, [field(90.0)], now) == kept


@pytest.mark.parametrize(
    ("evidence", "wins"), [(20.5, True), (19.5, False), (11.0, False), (39.0, True)]
)
def test_a_field_must_exceed_what_a_strong_effect_leaves(monkeypatch, evidence, wins):
    """Two per cent of its gain, a thousand."""
    now = outcome(step(trial(gain=1000.0)), last=())

    assert taken(monkeypatch, [field(evidence)], now, turn=1) == wins


@pytest.mark.parametrize(("evidence", "wins"), [(7.0, False), (9.0, False), (9.4, True)])
def test_a_field_that_no_name_points_at_shows_by_itself(monkeypatch, evidence, wins):
    """At odds of a hundred to one."""
    assert taken(monkeypatch, [field(evidence)], outcome()) == wins


@pytest.mark.parametrize("names", [0, 1])
def test_a_field_in_time_needs_a_name(monkeypatch, names):
    """What is smooth in time is what a drift is like."""
    worths = [field(90.0, of_time=True), field(-3.0)]
    now = outcome(*[step(trial())] * names)

    assert taken(monkeypatch, worths, now, together=50.0) == bool(names)


@pytest.mark.parametrize(
    ("antennas", "names", "wins"), [(3, 0, True), (4, 0, False), (30, 0, False), (30, 1, True)]
)
def test_a_field_in_an_array_needs_a_name(monkeypatch, antennas, names, wins):
    """What antennas share in a scan is too little known."""
    now = outcome(*[step(trial())] * names, blocks=SimpleNamespace(antennas=antennas))

    assert taken(monkeypatch, [field(90.0)], now, together=50.0) == wins


def test_a_field_that_nothing_determines_is_none(monkeypatch):
    """It has no direction that the data know."""
    assert not taken(monkeypatch, [field(90.0, directions=0)], outcome())


@pytest.mark.parametrize(("names", "evidence"), [(1, 195.0), (2, 178.0), (3, 161.0)])
def test_each_name_beyond_the_first_costs_twelve(names, evidence):
    """And each its price: gain less evidence."""
    steps = [step(trial("refraction", 20.0, gain=25.0))] * names

    assert instead._evidence(200.0, steps) == pytest.approx(evidence)


def test_a_p_value_is_the_share_of_draws_that_do_as_well():
    """Of 300 draws thirty at least as good: 31 of 301; of few the chance times the candidates."""
    drawn = np.where(np.arange(300) < 30, 12.0, 1.0)

    assert family_p_value([trial(gain=10.0, drawn=drawn)]) == pytest.approx(31 / 301)
    assert family_p_value([trial(gain=100.0, drawn=drawn)]) < 1e-9
    assert family_p_value([]) == 1.0
    low, high = (family_p_value([trial(gain=30.0, drawn=drawn, noise_dof=n)]) for n in (10, 1000))
    assert high < low / 10


def test_independent_candidates_multiply_the_chance():
    """Two candidates whose draws differ make the chance of the best twice that of one."""
    rng = np.random.default_rng(0)
    some = [trial(gain=40.0, drawn=rng.chisquare(1, 3000), noise_dof=10**6) for _ in range(20)]
    one = family_p_value(some[:1])
    every = family_p_value(some)

    assert one == pytest.approx(chi2.sf(40.0, 1), rel=0.1)
    assert every / one == pytest.approx(20, rel=0.4)


@pytest.mark.parametrize("dof", [1, 2, 6])
def test_the_gain_that_is_needed_has_the_evidence_that_is_asked(dof):
    """As `at_best` gives it for coefficients that are equally well known."""
    gain = gain_needed(trial(dof=dof, noise_dof=10**7), 12.0)
    evidence, _ = at_best(np.ones(dof), np.full(dof, np.sqrt(gain / dof)))

    assert evidence == pytest.approx(12.0, abs=0.1)
    assert gain_needed(trial(dof=dof, noise_dof=10), 12.0) > 1.5 * gain


@pytest.mark.parametrize("sessions", [4, 12])
def test_what_sessions_may_do_as_well_needs_a_larger_gain(sessions):
    """A change of one of them beside departures of all, whose variance is the best there is."""
    one = trial(noise_dof=10**7)
    gain = gain_needed(one, 12.0, sessions, 25.0)
    shares = np.full(sessions - 1, np.sqrt(gain / (sessions - 1)))
    change, _ = at_best(np.ones(1), np.array([np.sqrt(gain)]))
    departures, variance = at_best(np.ones(sessions - 1), shares)

    wide = 2 * np.log1p(variance / 25.0)
    assert change - departures + wide == pytest.approx(12.0, abs=0.5)
    assert gain > gain_needed(one, 12.0) * (3 if sessions == 4 else 1.05)
    assert gain_needed(one, 12.0, 2, 25.0) == np.inf


@pytest.mark.parametrize("scale", [ARCSEC, 3 * ARCSEC])
@pytest.mark.parametrize(("names", "gain"), [(1, 9.22), (6, 13.16)])
def test_a_limit_is_the_size_at_which_half_would_be_seen(scale, names, gain):
    """Ten readings of a column of two, one sigma 1 / sqrt(10): the gain of what convinces."""
    one = trial(sigma=scale / np.sqrt(10), noise_dof=10**6)
    columns = np.repeat([[2.0], [0.0]], 10, axis=0)  # it acts on one axis, and is read in two
    problem = problem_with(
        picked=lambda _: columns, candidates=[candidate(n) for n in NAMES[:names]]
    )
    limits = diagnose._limits(problem, SimpleNamespace(last=(one,)))

    assert limits["refraction"] == pytest.approx(2 * scale * np.sqrt(gain / 10), rel=0.01)


def test_a_limit_is_that_of_the_middle_member_and_of_a_change_that_of_its_sessions(monkeypatch):
    """The best member of a family is no case of half of it; where none is enough there is none."""
    asked = []
    answers = iter((4.0, 100.0, 9.0, np.inf))
    monkeypatch.setattr(
        diagnose, "gain_needed", lambda *given: asked.append(given) or next(answers)
    )
    nights = SimpleNamespace(of="session", labels=("a", "b", "c", "a"))
    problem = problem_with(
        picked=lambda _: np.ones((10, 1)),
        frame=SimpleNamespace(departures=(nights,)),
        pointing=np.arange(30),
        stack=SimpleNamespace(is_y=np.zeros(30, int)),
    )
    sigma = {"sigma": ARCSEC}
    trials = (*(trial(**sigma) for _ in range(3)), trial("epoch_tilt", **sigma))
    limits = diagnose._limits(problem, SimpleNamespace(last=trials))

    assert limits == {"refraction": pytest.approx(3.0 * ARCSEC)}
    assert [given[2:] for given in asked] == [(1, np.inf)] * 3 + [(3, 10.0)]


@pytest.mark.parametrize(("size_deg", "seen"), [(9.5, True), (10.5, False)])
def test_what_would_have_to_be_ten_degrees_cannot_be_seen(monkeypatch, size_deg, seen):
    """A clock's step of 256 deg, known from the pole alone, is no size to look for."""
    monkeypatch.setattr(diagnose, "gain_needed", lambda *_: size_deg**2)
    problem = problem_with(picked=lambda _: np.ones((10, 1)), candidates=())
    found = diagnose._limits(problem, SimpleNamespace(last=(trial(sigma=DEG),)))

    assert bool(found) == seen


def test_what_rounding_alone_sees_has_no_limit():
    """Nor has the part of a single antenna."""
    blind, own = trial("skew", sigma=np.inf), trial("tilt", sigma=ARCSEC, scope="antenna")
    problem = problem_with(picked=lambda _: np.ones((10, 1)), candidates=())
    with np.errstate(divide="raise"):
        found = diagnose._limits(problem, SimpleNamespace(last=(trial(sigma=ARCSEC), blind, own)))

    assert list(found) == ["refraction"]


@pytest.mark.parametrize(
    ("evidences", "left"),
    [((5.0, 9.0), 2), ((-0.5, 9.0), 1), ((0.5, 9.0), 2), ((-3.0, -9.0), 1)],
)
def test_what_others_made_idle_is_dropped(monkeypatch, evidences, left):
    """Evidence below zero beside the others; one always stays."""
    some = tuple(Chosen(candidate(name), "all") for name in NAMES[:2])
    worth = dict(zip((id(one) for one in some), evidences, strict=True))
    monkeypatch.setattr(winner, "alone", lambda _s, _w, _c, one: trial(evidence=worth[id(one)]))

    assert len(winner.without_idle(problem_with(), None, some)) == left


@pytest.mark.parametrize(
    ("effect", "antennas", "confounded"),
    [
        ("epoch_tilt", 1, True),
        ("epoch_tilt", 5, False),
        ("source_position", 1, True),
        ("source_position", 5, False),
        ("refraction", 1, False),
    ],
)
def test_what_nights_and_sources_may_do_is_confounded_in_a_single_antenna(
    effect, antennas, confounded
):
    """In an array the others show what the noise does."""
    blocks = SimpleNamespace(antennas=antennas)

    assert case.confounded(problem_with(blocks=blocks), candidate(effect).effect) == confounded


@pytest.mark.parametrize(
    ("effect", "scopes"),
    [
        ("epoch_tilt", ["all", "antenna"]),
        ("refraction", ["all", "session"]),
        ("site_longitude", ["all", "antenna"]),
        ("tilt", ["all", "session", "antenna", "antenna and session"]),
    ],
)
def test_scopes_are_those_that_physics_allows(effect, scopes):
    """A clock is one for all antennas; a mount has its own, and its place does not change."""
    every = ["all", "session", "antenna", "antenna and session"]
    found = winner._scopes(candidate(effect), SimpleNamespace(scopes=lambda: every))

    assert found == scopes


@pytest.mark.parametrize(("readings", "scopes"), [(240, 2), (239, 1), (12, 1)])
def test_four_readings_are_left_for_each_coefficient_of_an_antenna(readings, scopes):
    """Two of thirty antennas; of all together it is tried whatever there is."""
    blocks = Blocks(np.array([f"A{n:02d}" for n in range(30)]), np.full(30, ""))
    one = replace(candidate("tilt"), columns=np.arange(2))
    problem = SimpleNamespace(
        candidates=(one,), shapes=(), blocks=blocks, residual=np.zeros(readings)
    )
    asked = winner.trials_of(problem, SimpleNamespace(trials=list))

    assert [scope for _, scope in asked] == ["all", "antenna"][:scopes]


def test_sessions_may_differ_only_in_an_array():
    """Of a single antenna every effect is tried for all sessions together."""
    found = winner._scopes(candidate("tilt"), SimpleNamespace(scopes=lambda: ["all", "session"]))

    assert found == ["all"]


def still(setup_):
    """Return a covariance whose drifts and departures a test looks at."""
    noise = Noise(0.0, 1.0, ((2.0, 100.0), (1.0, 40000.0)))
    at = Circumstances(np.zeros(2), np.ones(2), columns={"time": np.arange(2.0)})
    setup_.stack, setup_.recordings = SimpleNamespace(row=np.arange(2)), SimpleNamespace(at=at)
    return changes.still_noise(
        setup_,
        Covariance(
            (),
            (noise,),
            np.ones(2),
            np.ones(2),
            (Departures("", "", "", (), np.ones((2, 1)), 1.0),),
        ),
    )


def test_changes_are_proposed_beside_noise_that_holds_still():
    """No departures; a memory beyond a session has what it changes within one."""
    part = SimpleNamespace(time=np.arange(20) * 1000.0, first=np.arange(20))
    problem = problem_with(session=np.arange(20) // 10, parts=[part])
    found = still(problem)

    assert found.departures == ()
    assert found.noises[0].drifts[0] == (2.0, 100.0)
    assert found.noises[0].drifts[1] == (pytest.approx(np.sqrt(9000 / 40000)), 9000.0)


def test_within_a_single_session_nothing_drifts():
    """A step in it is then seen as it is."""
    part = SimpleNamespace(time=np.arange(20) * 1000.0, first=np.arange(20))
    found = still(problem_with(session=np.zeros(20, int), parts=[part]))

    assert found.noises[0].drifts == ()


@pytest.mark.parametrize(
    ("rows", "back"), [([4, 5, 6, 7], 4), ([4, 5, 6, 8], 0), ([0, 1, 2, 3, 9], 4)]
)
def test_outliers_that_follow_each_other_are_readings_again(rows, back):
    """As many pointings as have the fewest readings in two axes; alone each stays an outlier."""
    at = Circumstances(np.zeros(20), np.ones(20), columns={"time": 1e9 - np.arange(20.0)})
    problem = problem_with(
        stack=SimpleNamespace(row=np.tile(np.arange(20), 2)), recordings=SimpleNamespace(at=at)
    )
    found = changes._consecutive(problem, np.isin(np.arange(40), rows))

    assert found[:20].sum() == found[20:].sum() == back
    assert not found[[8, 9, 28, 29]].any()


@pytest.mark.parametrize(("kept", "chance"), [((0, 1), 1e-9), ((1,), 1e-3), ((), 0.5)])
def test_the_chance_is_that_of_what_stands(kept, chance):
    """What was dropped no longer speaks for a mismatch."""
    turns = [replace(won(), sure=0.0) for _ in range(2)]
    steps = [
        Step(one.trial, one.chosen, (), None, p_value)
        for one, p_value in zip(turns, (1e-9, 1e-3), strict=True)
    ]
    end = outcome(*(steps[n] for n in kept))

    assert end.chance == chance


def steps_of(evidences):
    """Return a problem in which some kinds of change have columns of their own, and their trials.

    Each has the gain that gives it its evidence, beside a model of nothing.
    """
    n = len(evidences)
    columns, trials, data = np.eye(40)[:, :n], [], np.zeros(40)
    for k, (effect, evidence, *since) in enumerate(evidences):
        of = replace(candidate(effect), columns=np.array([k]))
        of = replace(of, effect=replace(of.effect, parameter=since[0] if since else None))
        trials.append(trial(of=of))
        # At the best width a single coefficient has gain - 1 - log(gain).
        gain = next(g for g in np.arange(1, 200, 0.01) if g - 1 - np.log(g) >= evidence)
        data[k] = np.sqrt(gain)
    plain = SimpleNamespace(noises=(), whiten=lambda columns: columns, departures=())
    return columns, trials, data, plain


def proposed(monkeypatch, evidences, **more):
    """Return the changes that are proposed for a closer look, with their evidence."""
    columns, trials, data, plain = steps_of(evidences)
    base = [
        Chosen(candidate(name), "all")
        for name in ("azimuth_zero", "elevation_zero", "tilt", "sag_cosine", "collimation")
    ]
    problem = problem_with(
        base=tuple(base),
        picked=lambda which: columns[:, which],
        residual=data,
        frame=SimpleNamespace(departures=more.get("departures", ())),
        expanded=lambda _, of: np.zeros((len(of), 1)),
    )
    monkeypatch.setattr(changes, "still_noise", lambda *_: plain)
    found = changes.proposed(problem, None, (), trials, more.get("banned", ()))[1]
    names = ["{}" if one.candidate.effect.parameter is None else "{} since" for one in found]
    effects = [one.candidate.effect.id for one in found]
    return {
        name.format(effect): one.evidence
        for name, effect, one in zip(names, effects, found, strict=True)
    }


def test_a_step_is_proposed_beside_the_best_single_session(monkeypatch):
    """Which the noise may do as well, however much more it promises."""
    found = proposed(monkeypatch, [("epoch_tilt", 90.0), ("epoch_tilt", 20.0, 1.2e9)])

    assert [round(one) for one in found.values()] == [90, 20]


def test_of_each_kind_of_change_the_best_is_proposed(monkeypatch):
    """However little it promises where it lies: its best moment is looked for first."""
    found = proposed(
        monkeypatch,
        [("epoch_tilt", 20.0), ("epoch_tilt", 30.0), ("epoch_sag", 2.0), ("drift", 40.0)],
    )

    assert set(found) == {"drift", "epoch_tilt", "epoch_sag"}
    assert found["epoch_tilt"] == pytest.approx(30.0, abs=0.5)


def test_what_is_banned_is_not_proposed(monkeypatch):
    """Nor what does not change with time."""
    assert proposed(monkeypatch, [("epoch_tilt", 30.0)], banned=("epoch_tilt",)) == {}
    assert proposed(monkeypatch, [("refraction", 30.0)]) == {}

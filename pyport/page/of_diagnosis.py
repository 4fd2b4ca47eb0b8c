"""A diagnosis as a picture and a story."""

from __future__ import annotations

import numpy as np

from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.searching.turns import Step
from pyport.effects.empirical.fields import UNKNOWN
from pyport.files import sha256
from pyport.fitting.fit import off_by
from pyport.fitting.table import MOST_COMBINATIONS
from pyport.models.model import Model
from pyport.page.markup import Linear, as_file, chance, linear, notes
from pyport.page.payload import layers, visible
from pyport.page.picture import Layer, Picture, Side, columns, sides
from pyport.page.story import Bar, Card, Rival, Source, Story, Turn, rows_of, sky_rms
from pyport.recordings.schema import Recordings
from pyport.report.finding import completed
from pyport.report.made import report_of
from pyport.report.typed import Finding, HeldOut, Report

#: Labels that distinguish recordings when one is pointed at.
LABELS = ("source", "antenna", "session", "receiver", "channel")
#: Candidates shown for each turn of the search.
MOST_RIVALS = 10


def of_diagnosis(diagnosis: Diagnosis, report: Report | None = None) -> tuple[Picture, Story]:
    """Return what the panels draw of a diagnosis, and what the page says of its report."""
    report = report or report_of(diagnosis)
    curves = visible(diagnosis)
    found, of_finding = layers(diagnosis, curves)
    problem = diagnosis.problem
    noise = {one: diagnosis_noise(diagnosis, is_y=one) for one in (False, True)}
    x, y = sides(
        problem.recordings,
        problem.stack,
        diagnosis.left(diagnosis.before),
        curves,
        diagnosis.share,
        (noise[False], noise[True]),
    )
    whole = completed(diagnosis)
    again = linear(whole, problem.recordings)
    picture = picture_of(problem.recordings, tuple(found), x, y, again=again)
    return picture, _story(diagnosis, report, picture, of_finding, whole)


def picture_of(
    recordings: Recordings,
    found: tuple[Layer, ...],
    x: Side,
    y: Side,
    names: tuple[str, str] = ("before", "after"),
    show: str = "both",
    again: Linear | None = None,
) -> Picture:
    """Return the picture of residuals on both axes of recordings."""
    at = recordings.at
    return Picture(
        time=np.asarray(at.column("time"), float) if "time" in at else None,
        line=recordings.line,
        columns=columns(recordings, found, [x.before, y.before]),
        labels={name: at.column(name).astype(str) for name in LABELS if name in at},
        layers=found,
        x=x,
        y=y,
        names=names,
        show=show,
        axes=at.mount.names,
        turn=at.turn,
        linear=again,
    )


def diagnosis_noise(diagnosis: Diagnosis, *, is_y: bool) -> float | None:
    """Return the noise of one axis [rad]: the median over the series on it."""
    pairs = zip(diagnosis.problem.parts, diagnosis.weighed.covariance.shown, strict=True)
    floors = [noise.floor for part, noise in pairs if part.is_y == is_y]
    return float(np.median(floors)) if floors else None


def _story(
    diagnosis: Diagnosis,
    report: Report,
    picture: Picture,
    of_finding: list[int | None],
    whole: Model,
) -> Story:
    names, matrix = _named(whole, report)
    headline, lead = _verdict(report)
    return Story(
        kind="diagnosis",
        source=source_of(diagnosis.problem.recordings),
        model=report.model.name,
        headline=headline,
        lead=lead,
        good=not report.mismatch,
        facts=_facts(report, picture, whole),
        cards=tuple(
            _card(finding, layer, diagnosis.problem.recordings.at.mount.names)
            for finding, layer in zip(report.findings, of_finding, strict=True)
        ),
        warnings=_warnings(report),
        bars=_bars(report),
        bars_how=report.fit.heldout.scheme,
        rows=rows_of(whole),
        correlation=(names, matrix),
        condition=report.condition_number,
        model_file=as_file(whole),
        turns=tuple(_turn(diagnosis, step) for step in diagnosis.steps),
        limits=tuple(sorted(report.detection_limit_arcsec.items(), key=lambda one: one[1])),
        untestable=tuple((one.effect, one.reason) for one in diagnosis.untestable),
        outliers=off_by(
            diagnosis.problem.recordings,
            diagnosis.problem.stack,
            diagnosis.left(diagnosis.after),
            diagnosis.weighed.used,
        ),
        noise=tuple(f"{one}." for one in report.noise.sentences),
        dropped=tuple(
            (one.effect.replace("_", " ") + (f", {one.variant}" if one.variant else ""), one.reason)
            for one in report.dropped
        ),
    )


def source_of(recordings: Recordings) -> Source:
    """Return what the story tells of the file."""
    file = recordings.file
    return Source(
        file.name,
        sha256(file) if file.is_file() else None,
        tuple(sorted(recordings.meta.items())),
        tuple((one.line, one.reason) for one in recordings.set_aside),
    )


def _named(whole: Model, report: Report) -> tuple[tuple[str, ...], tuple[tuple[float, ...], ...]]:
    """Return the correlations of what has a name: a field's numbers tell a reader nothing."""
    values = () if whole.completed is None else whole.completed.values
    nameless = {one.name for one in values if one.effect == UNKNOWN}
    names, matrix = report.correlation.names, report.correlation.matrix
    kept = [n for n, name in enumerate(names) if name not in nameless]
    return tuple(names[n] for n in kept), tuple(tuple(matrix[n][m] for m in kept) for n in kept)


def _verdict(report: Report) -> tuple[str, str]:
    """Return the verdict: a headline and a sentence."""
    model, held = report.model.name, report.fit.heldout
    what = (
        f"{_change(held)} arcsec rms on data that the fit "
        f"had not seen ({held.scheme}); noise alone is {held.noise_floor_arcsec:.3g}"
    )
    noise = chance(report.p_value)
    if report.verdict is not None:
        headline, _, more = report.verdict.partition("; ")
        lead = [f"{more[0].upper()}{more[1:]}."] if more else []
        if not report.too_few:
            lead.append(f"Noise alone looks like what {model} leaves (chance {noise}).")
        return f"{headline}.", " ".join(lead)
    names = [one.effect.replace("_", " ") for one in report.findings]
    missing = list(dict.fromkeys(n for n in names if n != "unknown"))
    nameless = names.count("unknown")
    if nameless:
        missing.append(
            "something without a name" if nameless == 1 else f"{nameless} nameless things"
        )
    whole = " and ".join([part for part in (", ".join(missing[:-1]), missing[-1]) if part])
    headline = f"{model} leaves out {whole}."
    return headline, f"{what}. The chance that noise alone looks like this: {noise}."


def _facts(report: Report, picture: Picture, whole: Model) -> tuple[tuple[str, str, str], ...]:
    """Return the key figures: name, value, and what it stands beside."""
    facts = []
    for name, side in picture.sides():
        before, after = (side.rms(one) / ARCSEC for one in (side.before, side.after))
        floor = "" if side.floor is None else f"arcsec rms; noise {side.floor / ARCSEC:.3g}"
        value = f"{before:.3g} → {after:.3g}" if picture.layers else f"{before:.3g}"
        facts.append((name, value, floor))
    held = report.fit.heldout
    value = _change(held) if picture.layers else f"{held.rms_before_arcsec:.3g}"
    facts.append(("held out", value, f"arcsec rms; noise {held.noise_floor_arcsec:.3g}"))
    facts += sky_rms(whole)
    aside = len(report.input.set_aside)
    facts.append(("recordings", f"{len(picture):,}", f"{aside:,} rows excluded"))
    return tuple(facts)


def _change(held: HeldOut) -> str:
    return f"{held.rms_before_arcsec:.3g} → {held.rms_after_arcsec:.3g}"


def _card(finding: Finding, layer: int | None, axes: tuple[str, str]) -> Card:
    facts = [("adds to the residuals", f"{finding.visible_rms_arcsec:.3g} arcsec rms")]
    if finding.true_rms_arcsec is not None:
        absorbed = f"{finding.true_rms_arcsec:.3g} arcsec rms"
        facts.append(("before the fitted terms absorb their share", absorbed))
    if finding.heldout is not None:
        held = finding.heldout
        fall = held.rms_before_arcsec - held.rms_after_arcsec
        error = f" ± {held.rms_fall_sigma_arcsec:.2g}" if held.rms_fall_sigma_arcsec else ""
        facts.append(("held out", f"{_change(held)} arcsec rms, less by {fall:.3g}{error}"))
    facts += [
        ("chance of noise", chance(finding.evidence.p_value)),
        ("gain in BIC", f"{finding.evidence.delta_bic:,.0f}"),
    ]
    return Card(
        title=finding.effect.replace("_", " ")
        + (f", {finding.variant}" if finding.variant and finding.effect != "unknown" else ""),
        verdict=finding.verdict,
        sentence=finding.sentence,
        facts=tuple(facts),
        notes=tuple(notes(finding, axes)),
        layer=layer,
    )


def _warnings(report: Report) -> tuple[str, ...]:
    said = [one for one in (report.misread, report.determines_nothing) if one]
    if report.noisy:
        said.append(f"Drown in their own noise and are not counted: {' '.join(report.noisy)}.")
    together = [one.sentence for one in report.combinations[:MOST_COMBINATIONS]]
    said += [f"{one[0].upper()}{one[1:]}." for one in together]
    said += [one.sentence for one in report.two_axes]
    said += [f"{one[0].upper()}{one[1:]}." for one in report.warnings]
    return tuple(said)


def bars_of(picture: Picture) -> tuple[Bar, ...]:
    """Return the rms of the residuals on each axis, before and after."""
    return tuple(
        Bar(name, side.rms(side.before) / ARCSEC, side.rms(side.after) / ARCSEC)
        for name, side in picture.sides()
    )


def _bars(report: Report) -> tuple[Bar, ...]:
    held = report.fit.heldout
    return (
        Bar("all", held.rms_before_arcsec, held.rms_after_arcsec, held.noise_floor_arcsec),
        *(
            Bar(one.antenna, one.heldout_before_arcsec, one.heldout_after_arcsec)
            for one in report.antennas
            if not one.drowns_in_noise
        ),
    )


def _turn(diagnosis: Diagnosis, step: Step) -> Turn:
    """Return the best candidates of a turn, each effect once."""
    best: dict[str, Rival] = {}
    members: set[str] = set()
    for finding in diagnosis.findings:
        if step.chosen.candidate.effect.id in finding.members:
            members |= set(finding.members)
    for trial in sorted(step.trials, key=lambda one: -one.delta_bic):
        effect = trial.candidate.effect
        if effect.id not in best:
            best[effect.id] = Rival(
                effect.id,
                effect.variant,
                trial.scope,
                trial.dof,
                trial.delta_bic,
                effect.id in members,
            )
    winner = step.winner.candidate.effect
    return Turn(winner.id, step.p_value, tuple(list(best.values())[:MOST_RIVALS]))

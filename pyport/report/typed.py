"""The report of a diagnosis: what JSON, terminal and page say, each key with its type and meaning.

Names are those of report.json, units and all. A number that is not known is None there and NaN
here.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from pyport.diagnosis.naming.finding import Evidence, Interval, Parameter

SCHEMA = "pyport.diagnosis/1"
#: Marks what is said on the terminal and stands in no file.
NOT_WRITTEN = {"written": False}


@dataclass(frozen=True)
class Excluded:
    """A row that is not used."""

    line: Annotated[int, "its line in the file"]
    reason: Annotated[str, "why"]


@dataclass(frozen=True)
class Input:
    """The recordings."""

    file: Annotated[str, "name of the file"]
    sha256: Annotated[str | None, "hash of its bytes"]
    rows: Annotated[int, "rows in the file"]
    used: Annotated[int, "rows that are used"]
    set_aside: Annotated[tuple[Excluded, ...], "rows that are not"]
    outliers: Annotated[int, "readings without weight"]
    reduction: Annotated[
        dict[str, Any] | None, "of a data set: rows, points, places, how wide a point is, outliers"
    ] = None


@dataclass(frozen=True)
class Held:
    """The model beside which effects were looked for."""

    name: Annotated[str, "of the model"]
    refit: Annotated[tuple[str, ...], "ids of the effects that were refitted"]


@dataclass(frozen=True)
class MountOf:
    """The mount."""

    name: Annotated[str, "its kind, as in `# mount:`"]
    axes: Annotated[dict[str, str], "what `xel` and `el` stand for on it"]


@dataclass(frozen=True)
class Departure:
    """What a session, stretch of rows or source adds to all its readings by chance."""

    term: Annotated[str, "term of the model that differs"]
    of: Annotated[str, "`session`, `source`, or `stretch` of rows that have an order and no time"]
    antenna: Annotated[str, "whose"]
    sigma_arcsec: Annotated[float, "scatter between them"]
    labels: Annotated[tuple[str, ...], "the sessions, stretches or sources"]
    most_label: Annotated[str, "which of them departs most, everything found fitted"]
    most_arcsec: Annotated[float, "by how much, drawn toward zero as few readings are"]


@dataclass(frozen=True)
class Growth:
    """An axis whose scatter changes with elevation."""

    axis: Annotated[str, "which"]
    low_el_deg: Annotated[float, "median elevation of the lowest fifth"]
    high_el_deg: Annotated[float, "and of the highest"]
    low_arcsec: Annotated[float, "scatter there"]
    high_arcsec: Annotated[float, "and there"]


@dataclass(frozen=True)
class Drift:
    """An axis of a single antenna that drifts, and the sessions furthest from usual."""

    axis: Annotated[str, "which"]
    rms_arcsec: Annotated[float, "rms by which it moved the readings"]
    memory_s: Annotated[float | None, "how long it remembers; null where rows have no time"]
    memory_rows: Annotated[float | None, "the same in rows; null where they have"]
    lowest_session: Annotated[str, "session of the lowest mean"]
    lowest_arcsec: Annotated[float, "that mean, everything found fitted"]
    highest_session: Annotated[str, "session of the highest mean"]
    highest_arcsec: Annotated[float, "and that mean"]


@dataclass(frozen=True)
class Noise:
    """Scatter about any model."""

    xel_arcsec: Annotated[float | None, "median over antennas, across"]
    el_arcsec: Annotated[float | None, "and along elevation"]
    correlation_time_s: Annotated[float | None, "longest time that a drift remembers"]
    how: Annotated[str, "`replicates`, `neighbours` or `reml`"]
    departures: Annotated[tuple[Departure, ...], "of sessions and sources"]
    drifts: Annotated[tuple[Drift, ...], "axes that drift noticeably"]
    by_elevation: Annotated[tuple[Growth, ...], "where scatter changes with elevation"]
    sentences: Annotated[tuple[str, ...], "all this in words"]


@dataclass(frozen=True)
class Place:
    """Where a mismatch is."""

    axes: Annotated[tuple[str, ...], "`xel`, `el` or both"]
    subset: Annotated[dict[str, list[str]], "label -> values to which it is confined"]
    region: Annotated[tuple[Interval, ...], "intervals that hold together"]
    curve: Annotated[tuple[dict[str, float], ...] | None, "`az_deg`, `el_deg` along an edge"]
    since: Annotated[str | None, "ISO 8601 time from which on"]
    until: Annotated[str | None, "ISO 8601 time before which, where it came back"]
    between: Annotated[tuple[str, ...] | None, "ISO 8601 times between which it began"]


@dataclass(frozen=True)
class HeldOut:
    """Predictions of readings that the fit had not seen: plain rms."""

    scheme: Annotated[str, "what was left out each time"]
    rms_before_arcsec: Annotated[float, "without what was found"]
    rms_after_arcsec: Annotated[float, "with it"]
    noise_floor_arcsec: Annotated[
        float, "scatter from pointing to pointing, which no model removes"
    ]
    not_counted: Annotated[int, "readings not predicted, or missed by far both times"]
    rms_fall_sigma_arcsec: Annotated[
        float | None, "error of before less after, from the stretches that were left out"
    ] = None


@dataclass(frozen=True)
class Stability:
    """How often a name came first on resampled data."""

    resampled: Annotated[str, "sessions, blocks of time or pointings"]
    draws: Annotated[int, "how often"]
    kept: Annotated[int, "draws in which the name came first"]
    names: Annotated[dict[str, int], "other names, and in how many draws"]
    weak: Annotated[int, "draws in which a change came first that noise could have done"]
    instead: Annotated[str | None, "the most frequent of them"]
    nameless: Annotated[int, "draws in which nothing was worth a name"]
    stable: Annotated[bool, "whether the name stands"]
    words: Annotated[str, "in words"] = field(default="", metadata=NOT_WRITTEN)


@dataclass(frozen=True)
class Known:
    """A combination of coefficients that the data know."""

    formula: Annotated[str, "as a sum"]
    weights_arcsec_per_unit: Annotated[tuple[float, ...], "of each coefficient"]
    value_arcsec: Annotated[float, "its value"]
    sigma_arcsec: Annotated[float, "and error"]


@dataclass(frozen=True)
class Combination:
    """Coefficients of which only combinations are known."""

    coefficients: Annotated[tuple[str, ...], "their names"]
    visible_share: Annotated[tuple[float, ...], "share of each column that the others leave"]
    sentence: Annotated[str, "in words"]
    known: Annotated[tuple[Known, ...], "the one that adds most to the offsets first"]


@dataclass(frozen=True)
class Finding:
    """One mismatch: what was left out, where, how big, how sure, what else it could be."""

    effect: Annotated[str, "id in the catalogue, or `unknown`"]
    variant: Annotated[str, "member of a family"]
    class_: Annotated[tuple[str, ...], "ids that the data cannot distinguish from it"]
    verdict: Annotated[str, "`named`, `ambiguous` or `unknown`"]
    sentence: Annotated[str, "what was left out"]
    where: Annotated[Place, "where it is"]
    parameters: Annotated[tuple[Parameter, ...], "its coefficients"]
    evidence: Annotated[Evidence, "how sure it is"]
    visible_rms_arcsec: Annotated[float, "rms that it adds to the residuals where it acts"]
    true_rms_arcsec: Annotated[float | None, "rms before the fitted terms absorb their share"]
    heldout: Annotated[HeldOut | None, "what it gains on unseen readings"]
    looks_like: Annotated[str | None, "frame, shape and nearest class of what has no name"]
    decide_by: Annotated[str | None, "the observation that decides within the class"]
    checks: Annotated[tuple[str, ...], "what was checked, and how it came out"]
    stability: Annotated[Stability | None, "on resampled data"]
    combination: Annotated[Combination | None, "where no coefficient is known alone"]
    size: Annotated[str, "in words"] = field(default="", metadata=NOT_WRITTEN)


@dataclass(frozen=True)
class Rms:
    """Residuals of a fit."""

    rms_xel_arcsec: Annotated[float | None, "across"]
    rms_el_arcsec: Annotated[float | None, "along elevation"]
    rms_sky_arcsec: Annotated[float | None, "both, by the pointing"]


@dataclass(frozen=True)
class Fits:
    """The fit before and after what was found."""

    before: Annotated[Rms, "the model alone"]
    after: Annotated[Rms, "with what was found"]
    heldout: Annotated[HeldOut, "on unseen readings"]
    rms_per_axis: Annotated[str, "how rms is counted on an axis"]
    rms_on_sky: Annotated[str, "and on the sky"]


@dataclass(frozen=True)
class Dropped:
    """An effect that was looked at and dropped."""

    effect: Annotated[str, "its id"]
    variant: Annotated[str, "member of a family"]
    reason: Annotated[str, "why"]


@dataclass(frozen=True)
class Figures:
    """A difference over its error."""

    sigmas: Annotated[float | None, "how many"]
    p_value: Annotated[float | None, "its chance"]


@dataclass(frozen=True)
class OfAxis:
    """A coefficient as one axis has it."""

    value: Annotated[float, "its value"]
    sigma: Annotated[float, "and error"]


@dataclass(frozen=True)
class OfBoth:
    """A coefficient as each axis has it."""

    name: Annotated[str, "of the coefficient"]
    unit: Annotated[str, "of both values"]
    xel: Annotated[OfAxis, "across"]
    el: Annotated[OfAxis, "along elevation"]


@dataclass(frozen=True)
class Halves:
    """What the two halves of the recordings say."""

    between_axes: Annotated[dict[str, Figures], "half -> both axes against each other"]
    between_halves: Annotated[dict[str, Figures], "axis -> both halves against each other"]


@dataclass(frozen=True)
class Cause:
    """An effect that would make both axes agree."""

    effect: Annotated[str, "its id"]
    leaves: Annotated[Figures, "difference that it leaves"]


@dataclass(frozen=True)
class TwoAxes:
    """An effect that comes out different from the two axes."""

    effect: Annotated[str, "its id"]
    sentence: Annotated[str, "in words"]
    sigmas: Annotated[float | None, "how far both axes are apart"]
    p_value: Annotated[float | None, "the chance of it"]
    parameters: Annotated[tuple[OfBoth, ...], "its coefficients"]
    halves: Annotated[tuple[Halves, ...], "the recordings in two halves"]
    causes: Annotated[tuple[Cause, ...], "what would make them agree"]


@dataclass(frozen=True)
class Antenna:
    """An antenna of an array, before and after what was found."""

    antenna: Annotated[str, "its name"]
    readings: Annotated[int, "that count"]
    drowns_in_noise: Annotated[bool, "whether it is not counted"]
    rms_before_arcsec: Annotated[float, "in the fit, before"]
    rms_after_arcsec: Annotated[float, "and after"]
    heldout_before_arcsec: Annotated[float, "on unseen readings, before"]
    heldout_after_arcsec: Annotated[float, "and after"]


@dataclass(frozen=True)
class Correlation:
    """Correlations of what one antenna in one session sees."""

    names: Annotated[tuple[str, ...], "coefficients"]
    matrix: Annotated[tuple[tuple[float, ...], ...], "in their order"]


@dataclass(frozen=True)
class Report:
    """What a diagnosis says."""

    schema: Annotated[str, "name and version of this list"]
    input: Annotated[Input, "the recordings"]
    model: Annotated[Held, "what was held to them"]
    mount: Annotated[MountOf, "what carries the telescope"]
    noise: Annotated[Noise, "scatter about any model"]
    verdict: Annotated[str | None, "what is said where nothing was found"]
    mismatch: Annotated[bool, "whether anything was"]
    p_value: Annotated[float, "chance that noise alone looks like this, over the whole search"]
    detection_limit_arcsec: Annotated[
        dict[str, float],
        "effect -> rms, over the readings that it acts on, seen in half of all cases",
    ]
    findings: Annotated[tuple[Finding, ...], "strongest first"]
    fit: Annotated[Fits, "before and after"]
    combinations: Annotated[tuple[Combination, ...], "coefficients that are not known alone"]
    dropped: Annotated[tuple[Dropped, ...], "effects looked at and dropped"]
    two_axes: Annotated[tuple[TwoAxes, ...], "effects that differ between the axes"]
    antennas: Annotated[tuple[Antenna, ...], "of an array, each one"]
    not_testable: Annotated[dict[str, str], "effect -> why these recordings cannot show it"]
    correlation: Annotated[Correlation, "of the coefficients"]
    condition_number: Annotated[float, "of the last fit's columns"]
    warnings: Annotated[tuple[str, ...], "what to know before trusting the numbers"]
    completed_model: Annotated[
        dict[str, Any] | None, "the model with everything found, as `--save` writes it"
    ]
    array: Annotated[
        dict[str, Any] | None, "of several antennas: what they share, `docs/recordings.md`"
    ] = None
    misread: Annotated[str | None, "how the file may have been misread"] = None
    determines_nothing: Annotated[
        str | None, "that the directions determine nothing of the model"
    ] = None
    too_few: Annotated[bool, "whether nothing was looked for"] = field(
        default=False, metadata=NOT_WRITTEN
    )
    noisy: Annotated[tuple[str, ...], "antennas that are not counted"] = field(
        default=(), metadata=NOT_WRITTEN
    )
    corrections: Annotated[tuple[str, ...], "the table of what to enter, in words"] = field(
        default=(), metadata=NOT_WRITTEN
    )


#: What is in a file only where it is there.
_OPTIONAL = frozenset({"array", "reduction"})


def as_json(value: Any) -> Any:  # noqa: ANN401 - whatever a report holds
    """Return a report, or a part of one, as JSON has it: what is not finite is null."""
    if dataclasses.is_dataclass(value):
        return {
            one.name.rstrip("_"): as_json(getattr(value, one.name))
            for one in dataclasses.fields(value)
            if one.metadata.get("written", True)
            and not (one.name in _OPTIONAL and getattr(value, one.name) is None)
        }
    if isinstance(value, Mapping):
        return {key: as_json(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [as_json(one) for one in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value

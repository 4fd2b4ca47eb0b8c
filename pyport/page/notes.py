"""What a card says of a finding in small print."""

from __future__ import annotations

from pyport.diagnosis.words import number
from pyport.report.typed import Finding

#: Parameters shown on a finding's card; the table has them all.
MOST_PARAMETERS = 4


def notes(finding: Finding) -> list[tuple[str, str]]:
    """Return what else there is to say of a finding: where, what else it could be, what next."""
    where = finding.where
    found = [
        (f"{one.column.replace('_', ' ')}", f"from {one.low:.4g} to {one.high:.4g}")
        for one in where.region
    ]
    found += [(name, " ".join(values)) for name, values in where.subset.items()]
    if where.since:
        found.append(("since", where.since))
    if finding.looks_like:
        found.append(("looks like", finding.looks_like))
    if len(finding.class_) > 1:
        found.append(("could as well be", ", ".join(finding.class_[1:]).replace("_", " ")))
    if len(finding.parameters) <= MOST_PARAMETERS:
        found += [(p.name.replace("_", " "), number(p)) for p in finding.parameters]
    if finding.evidence.runner_up not in (None, finding.effect):
        gain = finding.evidence.runner_up_delta_bic
        text = str(finding.evidence.runner_up).replace("_", " ")
        found.append(("next best", text if gain is None else f"{text}, gain in BIC {gain:,.0f}"))
    found += [("" if n else "checked", one) for n, one in enumerate(finding.checks)]
    if finding.stability is not None:
        found.append(("resampled", finding.stability.words))
    if finding.decide_by:
        found.append(("next", finding.decide_by))
    return found

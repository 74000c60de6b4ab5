"""The claims and their verdicts: as text for the terminal, as Markdown, and as JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from stiction.studies.claim_parts import Part
from stiction.studies.claims import CLAIMS, Outcome, verdict_of
from stiction.views.digits import finite
from stiction.views.rows import entry, record
from stiction.views.text import fitted

Outcomes = list[Outcome]


def claims_text(outcomes: Outcomes) -> str:
    """Every claim with its verdict, and its parts below it."""
    lines = []
    for claim, statement in CLAIMS.items():
        lines.append(f"{claim}. {statement}  {verdict_of(claim, outcomes).upper()}")
        lines += [
            fitted(
                f"   {outcome.part.name:<3} {_value(outcome):<27} wanted {_wanted(outcome.part):<14} "
                f"{outcome.verdict:<10} {outcome.part.statement}{_left_out(outcome)}",
                hang=" " * 7,
            )
            for outcome in _parts(claim, outcomes)
        ]
    return "\n".join(lines) + "\n"


def claims_record(outcomes: Outcomes) -> str:
    """What `stiction claims` says, as JSON: the status of each number is its verdict."""
    values = [
        entry(
            each.part.name, each.value, lower=each.lower, upper=each.upper, status=each.verdict,
            at={"claim": each.part.claim, "statement": each.part.statement, "least": finite(each.part.least),
                "most": finite(each.part.most), "left_out": list(each.left_out)},
        )
        for each in outcomes
    ]  # fmt: skip
    claims = [
        {"claim": number, "statement": statement, "verdict": verdict_of(number, list(outcomes))}
        for number, statement in CLAIMS.items()
    ]
    return record("claims", values, kind="claims", claims=claims)


def claims_markdown(outcomes: Outcomes) -> str:
    """A table with a row for each part."""
    lines = ["| | verdict | claim, and its numbers | value [95 %] | criterion |", "|---|---|---|---|---|"]
    for claim, statement in CLAIMS.items():
        lines.append(f"| **{claim}** | {_chip(verdict_of(claim, outcomes))} | **{statement}** | | |")
        for outcome in _parts(claim, outcomes):
            part = outcome.part
            lines.append(
                f"| {part.name} | {outcome.verdict} | {part.statement}{_left_out(outcome)} | {_value(outcome)} "
                f"| {_wanted(part)} |"
            )
    return _in_letters("\n".join(lines) + "\n")


def _chip(verdict: str) -> str:
    """A verdict that pages set in a colour of its own."""
    return f'<span class="verdict verdict-{verdict}">{verdict}</span>'


def _in_letters(text: str) -> str:
    """Symbols as the other pages write them."""
    for plain, letters in (("mu_s", "μ_s"), ("mu0", "μ0"), ("tau0", "τ0")):
        text = text.replace(plain, letters)
    return text


def variants_markdown(variants: Mapping[str, Outcomes]) -> str:
    """A table with a row for each part and a column for each variant; a star where some D are left out."""
    return _side_by_side(variants, lambda part: part.name, lambda outcome: f"{_starred(outcome)}, {outcome.verdict}")


def columns_markdown(columns: Mapping[str, Outcomes]) -> str:
    """The same with what each part is, and intervals."""

    def cell(outcome: Outcome) -> str:
        if not math.isfinite(outcome.value):
            return "cannot be put"
        star = r"\*" if outcome.left_out else ""
        return f"{_value(outcome)}{star} {outcome.verdict}"

    return _side_by_side(columns, lambda part: f"{part.name} {part.statement}; {_wanted(part)}", cell)


def _side_by_side(columns: Mapping[str, Outcomes], head: Callable[[Part], str], cell: Callable[[Outcome], str]) -> str:
    first = next(iter(columns.values()))
    lines = [f"| | {' | '.join(columns)} |", "|" + "---|" * (len(columns) + 1)]
    for claim in CLAIMS:
        verdicts = [f"**{verdict_of(claim, outcomes)}**" for outcomes in columns.values()]
        lines.append(f"| **{claim}** | {' | '.join(verdicts)} |")
        for row in [index for index, outcome in enumerate(first) if outcome in _parts(claim, first)]:
            cells = [cell(outcomes[row]) for outcomes in columns.values()]
            lines.append(f"| {head(first[row].part)} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _parts(claim: int, outcomes: Outcomes) -> Outcomes:
    return [outcome for outcome in outcomes if outcome.part.claim == claim]


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "none"


def _starred(outcome: Outcome) -> str:
    return _number(outcome.value) + (r"\*" if outcome.left_out else "")


def _value(outcome: Outcome) -> str:
    if not math.isfinite(outcome.value):
        return "none"
    return f"{_number(outcome.value)} [{_number(outcome.lower)}, {_number(outcome.upper)}]"


def _wanted(part: Part) -> str:
    if math.isinf(part.most):
        return f"above {part.least:g}"
    return f"below {part.most:g}" if math.isinf(part.least) else f"{part.least:g} to {part.most:g}"


def _left_out(outcome: Outcome) -> str:
    if not outcome.left_out:
        return ""
    return f" (without D = {', '.join(f'{dimension:.2f}' for dimension in outcome.left_out)})"

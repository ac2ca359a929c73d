"""The catalogue as the tables of docs/effects.md: a test compares them."""

from __future__ import annotations

from serpenoid.effects.base import USES, Effect, Parameter
from serpenoid.effects.catalogue import catalogue


def uses_table() -> str:
    """Every effect against simulate, NLP, fit and diagnose; numbers refer to the reasons below."""
    reasons = _reasons()
    lines = [
        "| effect | site | place | needs | simulate | NLP | fit | diagnose |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for effect in catalogue().values():
        cells = [_cell(effect, use, reasons) for use in USES]
        needs = ", ".join(sorted(effect.needs))
        lines.append(f"| `{effect.name}` | {effect.site} | {effect.place or ''} | {needs} | {' | '.join(cells)} |")
    lines.append("")
    lines += [f"{number}. {reason[0].upper()}{reason[1:]}." for number, reason in enumerate(reasons, start=1)]
    return "\n".join(lines)


def parameters_table() -> str:
    """Every parameter with unit, bounds and neutral value, and what the effect looks like."""
    lines = ["| effect | parameters | what it looks like | what to do |", "| --- | --- | --- | --- |"]
    for effect in catalogue().values():
        parameters = "<br>".join(_parameter(p) for p in effect.parameters)
        lines.append(f"| `{effect.name}` | {parameters} | {effect.looks_like} | {effect.what_to_do} |")
    return "\n".join(lines)


def _reasons() -> list[str]:
    return list(dict.fromkeys(reason for effect in catalogue().values() for reason in effect.reasons.values()))


def _cell(effect: Effect, use: str, reasons: list[str]) -> str:
    return "yes" if effect.applies_to(use) else f"no ({reasons.index(effect.reasons[use]) + 1})"


def _parameter(p: Parameter) -> str:
    neutral = "" if p.neutral is None else f", neutral {p.neutral:g}"
    return f"`{p.name}` [{p.units}] {p.lower:g} .. {p.upper:g}{neutral}: {p.meaning}"

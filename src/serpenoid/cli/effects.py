"""Print the catalogue of effects: what can be added to a model and what a diagnosis can name.

    serpenoid effects
    serpenoid effects slope         # one of them
    serpenoid effects --json

An effect enters a problem file or a model file as

    [[effects]]
    name = "worn_wheel"
    place = 4
    seizure = 0.5
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from serpenoid.effects.base import Effect, Parameter


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `effects`."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="one effect (default: all)")
    parser.add_argument("--json", action="store_true", help="print the records as JSON, nothing else")


def run(args: argparse.Namespace) -> int:
    """List."""
    from serpenoid.effects.catalogue import catalogue, find

    chosen = [find(args.name)] if args.name else list(catalogue().values())
    if args.json:
        sys.stdout.write(json.dumps([record(effect) for effect in chosen], indent=2) + "\n")
    elif args.name:
        sys.stdout.write("\n".join(_lines(chosen[0])) + "\n")
    else:
        _table(chosen)
    return 0


def record(effect: Effect) -> dict[str, Any]:
    """One effect as JSON values; null stands for infinity in a bound, and for a neutral value that there is not."""
    return {
        "name": effect.name,
        "site": effect.site,
        "place": effect.place,
        "parameters": [
            {
                "name": p.name,
                **units(p),
                "bounds": [p.lower, p.upper if math.isfinite(p.upper) else None],
                "neutral": "infinity" if p.neutral == math.inf else p.neutral,
                "meaning": p.meaning,
            }
            for p in effect.parameters
        ],
        "looks_like": effect.looks_like,
        "what_to_do": effect.what_to_do,
        "needs": sorted(effect.needs),
        "of_animals": None if effect.of_animals is None else vars(effect.of_animals),
        "does_not_apply": dict(effect.reasons),
    }


def units(p: Parameter) -> dict[str, str]:
    """`unit`, and `unit_with_dry_friction` and the like for laws that are not the default one."""
    from serpenoid.media import DEFAULT, LAWS

    others = {f"unit_with_{law.title.replace(' ', '_')}": law for law in LAWS.values() if law.name != DEFAULT}
    return {"unit": p.unit} | {key: p.unit_in(law) for key, law in others.items()}


def _table(effects: list[Effect]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else 160)
    table = Table("name", "site", "place", "parameters", "what it looks like", "what to do", show_lines=True)
    for effect in effects:
        parameters = "\n".join(_parameter(p) for p in effect.parameters)
        table.add_row(effect.name, effect.site, effect.place or "", parameters, effect.looks_like, effect.what_to_do)
    console.print(table, markup=False)


def _lines(effect: Effect) -> list[str]:
    place = f", at one {effect.place}" if effect.place else ""
    lines = [f"{effect.name} ({effect.site}{place})"]
    lines += [f"  {_parameter(p)}: {p.meaning}" for p in effect.parameters]
    lines += [f"  looks like: {effect.looks_like}", f"  what to do: {effect.what_to_do}"]
    if effect.of_animals:
        lines += [f"  of animals: {effect.of_animals.looks_like}", f"  what to do: {effect.of_animals.what_to_do}"]
    lines += [f"  needs: {', '.join(sorted(effect.needs))}"] if effect.needs else []
    return lines + [f"  not in {use}: {reason}" for use, reason in effect.reasons.items()]


def _parameter(p: Parameter) -> str:
    neutral = "" if p.neutral is None else f", neutral {p.neutral:g}"
    return f"{p.name} ({p.units}) {p.lower:g} .. {p.upper:g}{neutral}"

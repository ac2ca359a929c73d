"""A whole comparison: every passage of a campaign three ways, gait means, ratios, cost of transport."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.compare.plain import refuse_effects
from serpenoid.compare.ratios import RatioStatistics, ratio_statistics
from serpenoid.compare.three import Comparison, compare_passage
from serpenoid.compare.transport import CostPoint, CyclePower, PowerModel, cost_points, cycle_power, fit_power
from serpenoid.measure.load import Campaign
from serpenoid.measure.usage import said_once, total, usage
from serpenoid.model import Model

PAIRS = (("Exp", "Sim"), ("Exp", "Resim"), ("Sim", "Resim"))


AT_REST = 2.0  # times the RMS that noise makes of a displacement: of a body at rest one in fifty goes farther
TINY = 1e-12  # body lengths: far less than any marker's noise
NOTHING = "no trial has a motion file with a whole cycle in it: nothing to compare"
TOLD = 2e-3  # of the displacement: less than the tape measure that gave the lengths


@dataclass(frozen=True)
class Study:
    """Everything `compare` found."""

    model: Model
    comparisons: tuple[Comparison, ...]
    gaits: tuple[str, ...]  # those with all of the classes below
    displacement: dict[str, Floats]  # class -> mean over a gait's passages (G,) [body lengths]
    ratios: tuple[RatioStatistics, ...]
    cycles: tuple[CyclePower, ...]
    costs: tuple[CostPoint, ...]
    power: PowerModel | None
    notes: tuple[str, ...]


def compare_campaign(
    campaign: Campaign, model: Model, progress: Callable[[int, int, str], None] | None = None
) -> Study:
    """Compare every passage of every trial. The mean over a gait's passages is its performance, as in the paper."""
    refuse_effects(model)
    comparisons, cycles = [], []
    for index, trial in enumerate(campaign.trials):
        if progress is not None:
            progress(index, len(campaign.trials), trial.name)
        for passage in trial.passages:
            found = compare_passage(trial, passage, model, seed=index)
            if found is None:
                continue
            comparisons.append(found)
            power = cycle_power(trial, found, model.body.mass_kg) if model.body.mass_kg else None
            if power is not None:
                cycles.append(power)
    notes = said_once((trial.name, trial.notes) for trial in campaign.trials)
    moved, still = moving(comparisons)
    gaits, displacement = gait_means(moved)
    ratios, complaint = _ratios(gaits, displacement)
    if cycles and not model.body.mass_kg:
        notes.append("[body] has no `mass_kg`: no cost of transport")
    return Study(
        model, tuple(comparisons), gaits, displacement, ratios, tuple(cycles), cost_points(cycles), fit_power(cycles),
        tuple([*_seconds(campaign, comparisons), *notes, *shape_bias(moved), *still, *complaint]),
    )  # fmt: skip


def _seconds(campaign: Campaign, comparisons: list[Comparison]) -> list[str]:
    return [f"{total(map(usage, campaign.trials))}"] if comparisons else []


def moving(comparisons: list[Comparison]) -> tuple[list[Comparison], list[str]]:
    """The passages of gaits that moved the body farther than noise shows of one at rest; words on the others.

    At rest the mean of (displacement / sd)^2 is 1 whatever the passages' sd, so one whose ends are seen poorly hides no
    others.
    """
    each: dict[str, list[tuple[float, float]]] = {}
    for c in comparisons:
        each.setdefault(c.gait, []).append((c.exp.displacement, c.exp_sd))
    far, sd = ({gait: np.array(values)[:, k] for gait, values in each.items()} for k in (0, 1))
    over = {gait: np.sqrt(np.mean((far[gait] / np.maximum(sd[gait], TINY)) ** 2)) for gait in each}
    still = {gait: float(np.sqrt(np.mean(far[gait] ** 2))) for gait in each if over[gait] <= AT_REST}
    if not still:
        return comparisons, []
    words = (
        f"{', '.join(still)}: the body moved no farther than the markers' noise shows of one at rest "
        f"({max(still.values()):.2g} body lengths); nothing is compared with that"
    )
    return [c for c in comparisons if c.gait not in still], [words]


def shape_bias(comparisons: list[Comparison]) -> list[str]:
    """What is said where noise of the shapes moves Resim by more than its scatter over a gait's passages."""
    known = [c for c in comparisons if np.isfinite(c.resim_bias) and c.resim.displacement > 0]
    if not known:
        return []
    share = float(np.mean([c.resim_bias / c.resim.displacement for c in known]))
    scatter = float(np.sqrt(np.mean([(c.resim_sd / c.resim.displacement) ** 2 for c in known]) / len(known)))
    if abs(share) < max(2 * scatter, TOLD):
        return []
    which = "shorter" if share < 0 else "longer"
    return [
        f"noise of the measured shapes makes Resim {abs(share):.1%} {which} than it is (scatter {scatter:.2%}): "
        "Exp and Resim differ by that much without a cause"
    ]


def gait_means(comparisons: list[Comparison]) -> tuple[tuple[str, ...], dict[str, Floats]]:
    """Mean displacement of every gait in every class; Sim only where every gait has one."""
    gaits = tuple(dict.fromkeys(c.gait for c in comparisons))
    rows: dict[str, list[float]] = {"Exp": [], "Sim": [], "Resim": []}
    for gait in gaits:
        mine = [c for c in comparisons if c.gait == gait]
        rows["Exp"].append(float(np.mean([c.exp.displacement for c in mine])))
        rows["Resim"].append(float(np.mean([c.resim.displacement for c in mine])))
        simulated = [c.sim.displacement for c in mine if c.sim is not None]
        rows["Sim"].append(float(np.mean(simulated)) if len(simulated) == len(mine) else float("nan"))
    found = {name: np.array(values) for name, values in rows.items()}
    return gaits, {name: values for name, values in found.items() if len(values) and np.isfinite(values).all()}


def _ratios(gaits: tuple[str, ...], displacement: dict[str, Floats]) -> tuple[tuple[RatioStatistics, ...], list[str]]:
    if len(gaits) < 2:
        return (), [] if not gaits else ["performance ratios need two gaits or more"]
    usable = [(x, y) for x, y in PAIRS if x in displacement and y in displacement]
    return tuple(ratio_statistics(f"{x}/{y}", displacement[x], displacement[y]) for x, y in usable), []

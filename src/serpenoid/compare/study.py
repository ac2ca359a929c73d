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
from serpenoid.measure.usage import total, usage
from serpenoid.model import Model

PAIRS = (("Exp", "Sim"), ("Exp", "Resim"), ("Sim", "Resim"))


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
    comparisons, cycles, notes = [], [], []
    for index, trial in enumerate(campaign.trials):
        if progress is not None:
            progress(index, len(campaign.trials), trial.name)
        notes += [f"{trial.name}: {note}" for note in trial.notes]
        for passage in trial.passages:
            found = compare_passage(trial, passage, model, seed=index)
            if found is None:
                continue
            comparisons.append(found)
            power = cycle_power(trial, found, model.body.mass_kg) if model.body.mass_kg else None
            if power is not None:
                cycles.append(power)
    gaits, displacement = gait_means(comparisons)
    ratios, complaint = _ratios(gaits, displacement)
    if cycles and not model.body.mass_kg:
        notes.append("[body] has no `mass_kg`: no cost of transport")
    return Study(
        model, tuple(comparisons), gaits, displacement, ratios, tuple(cycles), cost_points(cycles), fit_power(cycles),
        tuple([f"{total(map(usage, campaign.trials))}", *notes, *shape_bias(comparisons), *complaint]),
    )  # fmt: skip


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
        return (), ["performance ratios need two gaits or more"]
    usable = [(x, y) for x, y in PAIRS if x in displacement and y in displacement]
    return tuple(ratio_statistics(f"{x}/{y}", displacement[x], displacement[y]) for x, y in usable), []

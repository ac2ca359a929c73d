"""Recordings from Python: `measure`, `fit`, `compare` and `diagnose` a campaign, as the commands of these names do.

Each returns what was found, typed, short to print, with a picture in Jupyter; nothing is written.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.compare.calibrate import Calibration, calibrate, drag_ratio, wider_intervals
from serpenoid.compare.start import compared_model, neutral_model
from serpenoid.compare.study import NOTHING, Study, compare_campaign
from serpenoid.diagnose.campaign import diagnose_campaign
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.reference import reference_of
from serpenoid.diagnose.start import check_reference
from serpenoid.errors import InputError
from serpenoid.measure.campaign import CampaignFile, load_campaign_file
from serpenoid.measure.load import Campaign, load_campaign
from serpenoid.model import Model
from serpenoid.shown import Shown
from serpenoid.wording import counted

Place = str | Path


@dataclass(frozen=True, repr=False, eq=False)
class Measured(Shown):
    """A campaign as it was recorded: `campaign.trials` with markers, shapes, poses, commands, aligned in time."""

    campaign: Campaign

    def summary(self) -> str:
        """Trials and vertices."""
        campaign = self.campaign
        return f"{campaign.file.name}: {counted(len(campaign.trials), 'trial')}, {campaign.body.vertices} vertices"


@dataclass(frozen=True, repr=False, eq=False)
class Fitted(Shown):
    """Numbers fitted to a campaign: `calibration.together` to all trials together, `calibration.trials` one by one."""

    campaign: Campaign
    model: Model
    calibration: Calibration

    @property
    def drag_ratio(self) -> tuple[float, float, float]:
        """K = 1 / eps of all trials together (NaN: these data do not determine it), and its 95 % interval."""
        return drag_ratio(self.calibration.together, self.model)

    def summary(self) -> str:
        """Every number with its 95 % interval, the widest of them, and what is to be said against it."""
        best = self.calibration.together
        shown = ["not determined" if np.isnan(value) else f"{value:.4g}" for value in best.told]
        numbers = zip(best.names, shown, wider_intervals(best, self.model), strict=True)
        said = ", ".join(f"{name} {value} (95 %: {low:.4g} .. {high:.4g})" for name, value, (low, high) in numbers)
        return "; ".join([said, *best.warnings])


@dataclass(frozen=True, repr=False, eq=False)
class Compared(Shown):
    """Measured, simulated and resimulated motion: `study.comparisons`, `study.ratios`; where its eps comes from."""

    campaign: Campaign
    study: Study
    origin: str

    def summary(self) -> str:
        """How far resimulated gaits go, of measured ones."""
        if not self.study.gaits:
            return "the body did not move"
        shares = self.study.displacement["Resim"] / self.study.displacement["Exp"]
        eps = self.study.model.medium.anisotropy_ratio
        said = f"{counted(len(shares), 'gait')}, Resim / Exp {shares.min():.3f} .. {shares.max():.3f}"
        return f"{said}, anisotropy ratio {eps:.4g} ({self.origin})"


@dataclass(frozen=True, repr=False, eq=False)
class Diagnosed(Shown):
    """What the model gets wrong: `diagnosis.verdict`, `diagnosis.named`, `diagnosis.model` (extended)."""

    file: CampaignFile
    diagnosis: Diagnosis

    def summary(self) -> str:
        """Verdict, causes, and the error on gaits that were not fitted."""
        d = self.diagnosis
        found = ", ".join(n.effect.name + ("" if n.effect.place is None else f" at {n.effect.place}") for n in d.named)
        return f"{self.file.name}: {d.verdict}" + (f" ({found})" if found else "")


def measure(campaign: Place) -> Measured:
    """Read a campaign (a folder, or its TOML file); InputError names the file, row and column that is wrong."""
    return Measured(load_campaign(campaign))


def fit(
    campaign: Place,
    parameters: Sequence[str] = ("anisotropy_ratio",),
    anisotropy_ratio: float | None = None,
    dissipation: str | None = None,
) -> Fitted:
    """Fit `parameters`, beginning at `anisotropy_ratio` (default: the campaign's, else a guess)."""
    read = load_campaign(campaign)
    model = neutral_model(read, anisotropy_ratio, dissipation)
    return Fitted(read, model, calibrate(read, model, tuple(parameters)))


def compare(campaign: Place, anisotropy_ratio: float | None = None, dissipation: str | None = None) -> Compared:
    """Exp, Sim and Resim of every cycle; without an anisotropy ratio, it is fitted to all trials together first."""
    read = load_campaign(campaign)
    model, origin = compared_model(read, anisotropy_ratio, dissipation)
    study = compare_campaign(read, model)
    if not study.comparisons:
        raise InputError("; ".join([NOTHING, *study.notes]))
    return Compared(read, study, origin)


def diagnose(campaign: Place, model: Place | None = None, reference: Place | None = None) -> Diagnosed:
    """Find out what `model` (a problem or model file) gets wrong, or what changed since the campaign `reference`."""
    if reference is None:
        return Diagnosed(*diagnose_campaign(campaign, model))
    check_reference(reference, load_campaign_file(reference)[0], campaign, load_campaign_file(campaign)[0], "reference")
    earlier = reference_of(diagnose_campaign(reference, model, apart=False)[1])
    return Diagnosed(*diagnose_campaign(campaign, model, earlier))

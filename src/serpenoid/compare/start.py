"""The model that a campaign is compared with, and where a fit begins."""

from __future__ import annotations

from serpenoid.files.schema import validate
from serpenoid.measure.load import Campaign
from serpenoid.medium import FIRST_GUESS, Medium
from serpenoid.model import Model


def stated_model(campaign: Campaign, eps: float | None = None, dissipation: str | None = None) -> Model | None:
    """The recorded body in the medium that the caller or the campaign states; None where neither gives eps."""
    medium = campaign.file.medium
    if eps is None and (medium is None or medium.anisotropy_ratio is None):
        return None
    return neutral_model(campaign, eps, dissipation)


def neutral_model(campaign: Campaign, eps: float | None = None, dissipation: str | None = None) -> Model:
    """Where a fit begins: as stated, else at a first guess of eps."""
    medium = campaign.file.medium
    data = medium.guessed().model_dump() if medium is not None else {"anisotropy_ratio": FIRST_GUESS}
    data |= {} if eps is None else {"anisotropy_ratio": eps}
    data |= {} if dissipation is None else {"dissipation": dissipation}
    return Model(campaign.body, validate(Medium, data, "anisotropy ratio" if eps is not None else "campaign"))


def compared_model(campaign: Campaign, eps: float | None = None, dissipation: str | None = None) -> tuple[Model, str]:
    """The stated model, else eps fitted to all trials together; and where it comes from."""
    stated = stated_model(campaign, eps, dissipation)
    if stated is not None:
        return stated, f"as stated; K = {1 / stated.medium.anisotropy_ratio:.4g}"
    from serpenoid.compare.calibrate import anisotropy, drag_ratio
    from serpenoid.compare.parameters import changed

    start = neutral_model(campaign, eps, dissipation)
    if not any(trial.passages for trial in campaign.trials):
        return start, "nothing to fit it to"
    found = anisotropy(campaign, start)
    ratio, low, high = drag_ratio(found, start)
    noise = f"95 % {found.interval[0, 0]:.6g} .. {found.interval[0, 1]:.6g} by noise alone"
    if not found.determined.all():
        return start, f"a guess: these data do not determine it, {noise}"
    how_sure = f"{noise}; K = {ratio:.4g}, 95 % {low:.4g} .. {high:.4g} by what is left, too"
    return changed(start, found.names, found.values), f"fitted to all trials together, {how_sure}"

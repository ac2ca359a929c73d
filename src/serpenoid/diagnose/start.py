"""Where a diagnosis begins: the baseline medium."""

from __future__ import annotations

from pathlib import Path

from serpenoid import schema
from serpenoid.measure.campaign import CampaignFile
from serpenoid.medium import Medium
from serpenoid.model import Model

FIRST_GUESS = 0.2


def baseline(path: str | Path | None, file: CampaignFile) -> Model:
    """The campaign's body in the medium of a problem or model file (else of the campaign, else a first guess)."""
    medium = file.medium or Medium(anisotropy_ratio=FIRST_GUESS)
    if path is not None:
        data = schema.read_toml(path).get("medium")
        if data is not None:
            medium = schema.validate(Medium, data, str(path))
    return Model(file.body, medium)

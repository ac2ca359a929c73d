"""Where a diagnosis begins: the baseline medium, and effects of it that are known."""

from __future__ import annotations

from pathlib import Path

from serpenoid.body import Body
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import MediumEffect
from serpenoid.errors import InputError
from serpenoid.files import schema
from serpenoid.files.schema import Record
from serpenoid.measure.campaign import CampaignFile
from serpenoid.medium import Medium
from serpenoid.model import Model

FIRST_GUESS = 0.2


class _Known(Record):
    effects: tuple[ActiveEffect, ...] = ()


def baseline(path: str | Path | None, file: CampaignFile, body: Body) -> Model:
    """The recorded body in the medium of a problem or model file (else of the campaign, else a first guess).

    Effects of the medium in a model file are known, and no news.
    """
    medium, known = file.medium or Medium(anisotropy_ratio=FIRST_GUESS), tuple[ActiveEffect, ...]()
    if path is not None:
        data = schema.read_toml(path, "model")
        if "medium" in data:
            medium = schema.validate(Medium, data["medium"], str(path))
        known = schema.validate(_Known, {"effects": data.get("effects", [])}, str(path)).effects
    for effect in known:
        if not isinstance(effect.effect, MediumEffect):
            raise InputError(
                f"{path}: `{effect.name}` is no effect of the medium. What servos and cameras are known to do is taken "
                "from an earlier campaign: --reference CAMPAIGN."
            )
    if medium.dissipation != "vertex":
        where = path or f"campaign `{file.name}`"
        raise InputError(
            f'{where}: a diagnosis needs [medium] dissipation = "vertex", where effects have their places.'
        )
    return Model(body, medium, known)


def check_body(path: str | Path | None, file: CampaignFile) -> None:
    """InputError where a file describes another robot than the one that was recorded; animals' points are resampled."""
    body = schema.read_toml(path).get("body") if path is not None else None
    vertices = body.get("vertices") if isinstance(body, dict) else None
    if vertices not in (None, file.body.vertices):
        raise InputError(
            f"{path}: a body of {vertices} vertices, but the campaign `{file.name}` records one of "
            f"{file.body.vertices}. Give the problem file of the robot that was recorded."
        )

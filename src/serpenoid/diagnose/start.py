"""Where a diagnosis begins (the baseline medium) and how it ends on the screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from serpenoid import schema
from serpenoid.diagnose.reference import words
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


def lines(record: dict[str, Any]) -> list[str]:
    """The summary."""
    found = [f"reference         {text}" for text in words(record["reference"])] if record["reference"] else []
    found += [f"verdict           {record['verdict']}"]
    for e in record["effects"]:
        where = "" if e["place"] is None else f" at {e['place']}"
        found.append(f"  {e['name']}{where} ({e['strength_floors']:.1f} floors)")
        for name, p in e["parameters"].items():
            low, high = p["interval"]
            found.append(f"    {name:14}{p['value']:.4g} {p['unit']}   95 % {_end(low)} .. {_end(high)}")
    for e in record["alternatives"]:
        where = "" if e["place"] is None else f" at {e['place']}"
        found.append(f"  or {e['name']}{where}")
    rms = record["gain"]["path_rms_m"]
    found.append(f"path RMS          {1e3 * rms['before']:.2f} -> {1e3 * rms['after']:.2f} mm on held-out gaits")
    found.append(f"noise floor       {1e3 * record['noise_floor_m']:.2f} mm")
    return found + [f"left              {text}" for text in record["residual_pattern"]]


def _end(value: float | None) -> str:
    return "?" if value is None else f"{value:.4g}"

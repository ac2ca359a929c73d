"""diagnosis.json and extended-model.toml."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from serpenoid.diagnose.diagnose import Diagnosis, record
from serpenoid.files import provenance, write_json
from serpenoid.measure.campaign import CampaignFile
from serpenoid.model_file import write_model_file


def write(folder: Path, file: CampaignFile, d: Diagnosis, figures: bool = True) -> dict[str, Any]:
    """Write everything; returns the record."""
    data = record(d) | {"campaign": file.name, "source": file.source, "provenance": provenance()}
    comment = f"what the diagnosis of {file.name} found: {d.verdict}"
    write_model_file(folder / "extended-model.toml", d.model.medium, d.model.effects, comment=comment)
    write_json(folder / "diagnosis.json", data)
    return data

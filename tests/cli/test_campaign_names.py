"""Where results of a campaign go when --out does not say."""

from __future__ import annotations

from pathlib import Path

import pytest

from serpenoid.cli.campaigns import name_of


@pytest.mark.parametrize(
    ("path", "name"), [("foam", "foam"), ("foam/campaign.toml", "foam"), ("lamprey.toml", "lamprey")]
)
def test_results_are_named_after_the_folder_or_the_file(path: str, name: str, tmp_path: Path) -> None:
    (tmp_path / "foam").mkdir()
    assert name_of(str(tmp_path / path)) == name

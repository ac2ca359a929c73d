"""Where results go, and that a place where nothing can be written is refused before the work."""

from __future__ import annotations

from pathlib import Path

import pytest

from serpenoid.cli.campaigns import name_of
from serpenoid.cli.options import check_writable
from serpenoid.errors import InputError


@pytest.mark.parametrize(
    ("path", "name"), [("foam", "foam"), ("foam/campaign.toml", "foam"), ("lamprey.toml", "lamprey")]
)
def test_results_are_named_after_the_folder_or_the_file(path: str, name: str, tmp_path: Path) -> None:
    (tmp_path / "foam").mkdir()
    assert name_of(str(tmp_path / path)) == name


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="a folder that refuses even the superuser: Linux has one")
def test_a_place_that_takes_no_files_is_refused() -> None:
    with pytest.raises(InputError, match="/proc cannot be written to"):
        check_writable(Path("/proc/results/deeper"))


@pytest.mark.parametrize(("target", "below"), [("nowhere", ""), ("nowhere", "deeper"), ("link", "")])
def test_a_link_to_what_is_not_there_is_refused(tmp_path: Path, target: str, below: str) -> None:
    (tmp_path / "link").symlink_to(tmp_path / target)
    with pytest.raises(InputError, match="link is a link to what is not there"):
        check_writable(tmp_path / "link" / below)


def test_a_new_folder_is_not_made_by_asking(tmp_path: Path) -> None:
    check_writable(tmp_path / "a" / "b")
    assert list(tmp_path.iterdir()) == []

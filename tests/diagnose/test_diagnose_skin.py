"""One vertex that rubs more along the body, or less: of a body without wheels its skin, of any other its wheel."""

from __future__ import annotations

from pathlib import Path

import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.diagnose.campaign import diagnose_campaign

VERTEX = 8


@pytest.mark.parametrize(("roughness", "gaits"), [(1.0, 2), pytest.param(-0.5, 3, marks=pytest.mark.slow)])
def test_a_crawling_robots_rough_or_smooth_link_is_named_as_its_skin(
    roughness: float, gaits: int, tmp_path: Path
) -> None:
    _campaign(tmp_path, roughness, "crawling robot", gaits)
    _, found = diagnose_campaign(tmp_path)
    assert found.verdict == "explained"
    assert [(n.effect.name, n.effect.place) for n in found.named] == [("rough_skin", VERTEX)]
    low, high = found.named[0].intervals["roughness"]
    assert low is not None
    assert high is not None
    assert low < roughness < high < low + 0.4


@pytest.mark.slow
def test_without_a_kind_the_same_is_a_worn_wheel(tmp_path: Path) -> None:
    eps = _campaign(tmp_path, 1.0, None)
    _, found = diagnose_campaign(tmp_path)
    assert [(n.effect.name, n.effect.place) for n in found.named] == [("worn_wheel", VERTEX)]
    low, high = found.named[0].intervals["seizure"]
    assert low is not None
    assert high is not None
    assert low < eps / (1 - eps) < high


def _campaign(folder: Path, roughness: float, kind: str | None, gaits: int = 2) -> float:
    """Files of a robot of this kind with one rough vertex; its anisotropy ratio."""
    campaign = make(5, [Effect("rough_skin", VERTEX, {"roughness": roughness})], "skin", COMBINATIONS[:gaits])
    write(campaign, folder)
    file = folder / "campaign.toml"
    said = "" if kind is None else f'kind = "{kind}"\n'
    file.write_text(file.read_text().replace("[body]\n", f"[body]\n{said}"))
    return campaign.eps

"""Parts that are all a little different: what they do to values and names, and how often chance is taken for them; and
several that differ much."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.random_protocols import draw_protocol
from blind.windows import windows
from serpenoid.body import Body
from serpenoid.diagnose.campaign import diagnose_campaign
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.doubt.differing import _Drawn
from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, candidates_of, fit, with_values
from serpenoid.diagnose.inference.search import all_places
from serpenoid.diagnose.inference.search.all_places import all_at_once
from serpenoid.diagnose.inference.search.select import calibrated, one_for_several
from serpenoid.effects.active import ActiveEffect
from serpenoid.medium import Medium
from serpenoid.model import Model

VERTICES, WINDOWS, NORMAL = 10, 200, 1.96
NAMED = ActiveEffect.of("load", 0, share=0.1)


def drawn(rng: np.random.Generator, sd: float) -> _Drawn:
    """Of windows that eps, a named load and parts of this SD about neutral move, at their true values but for the
    parts."""
    parts = tuple(ActiveEffect.neutral("load", place) for place in range(1, VERTICES))
    model = Model(Body(vertices=VERTICES), Medium(anisotropy_ratio=0.2), (NAMED,))
    columns = rng.normal(size=(WINDOWS, 1 + VERTICES)) @ rng.normal(size=(1 + VERTICES, 1 + VERTICES))
    left = columns[:, 2:] @ rng.normal(0, sd, len(parts)) + rng.normal(size=WINDOWS)
    evidence = Evidence.of(left, columns, np.arange(WINDOWS) % 4)
    return _Drawn(model, (NAMED, *parts), len(parts), evidence, ())


def test_values_beside_parts_that_differ_hold_the_truth_as_often_as_they_say() -> None:
    rng = np.random.default_rng(1)
    several = [drawn(rng, 0.3) for _ in range(150)]
    off = np.array([(d.likeliest[1] - NAMED.parameters["share"]) / d.deviations[1] for d in several])
    # 95 % stated; of nine parts their own SD is known to a quarter; 150 draws: SD 2 %
    assert 0.88 < np.mean(np.abs(off) < NORMAL) < 0.99
    assert np.median([d.size for d in several]) == pytest.approx(0.3, rel=0.15)


def test_parts_that_are_alike_are_taken_to_differ_as_seldom_as_stated() -> None:
    rng = np.random.default_rng(2)
    several = [drawn(rng, 0.0) for _ in range(120)]
    assert 0.01 < np.mean([d.gained > d.by_chance(0.05) for d in several]) < 0.1


@pytest.mark.slow
def test_a_healthy_robot_whose_wheels_differ_has_no_name_without_a_mark(tmp_path: Path) -> None:
    """Seizures of 0.02 to 0.1; eps takes what they have in common. A name of the whole body fits about as well."""
    protocol = draw_protocol(901)
    seizures = np.random.default_rng([901, 77]).uniform(0, 0.16, protocol.robot.vertices)
    wheels = [Effect("worn_wheel", k, {"seizure": float(s)}) for k, s in enumerate(seizures)]
    write(make(901, wheels, "wheels", protocol=protocol), tmp_path / "wheels")
    _, found = diagnose_campaign(tmp_path / "wheels")
    assert found.verdict == "partly explained"
    assert found.named
    assert all(n.stand_in or n.effect.name == "worn_wheel" for n in found.named)
    assert any("parts are not alike: worn_wheel varies" in w for w in found.words)


@pytest.mark.slow
def test_a_payload_takes_the_place_of_what_all_other_vertices_lack(tmp_path: Path) -> None:
    """Forces count by shares: less weight everywhere else is a load."""
    vertex, share = 4, 0.25
    campaign = make(6, [Effect("load", vertex, {"share": share})], "short", COMBINATIONS[:2])
    write(campaign, tmp_path)
    motion, model = windows(tmp_path, campaign.eps)
    weights, others = model.body.vertex_weights, [k for k in range(model.body.vertices) if k != vertex]
    less = share / (weights[vertex] + share)  # of every other weight: then all are in proportion
    lacking = [ActiveEffect.of("load", k, share=-less * weights[k]) for k in others]
    start = np.array([campaign.eps, *(e.parameters["share"] for e in lacking)])
    motion, begun = calibrated(motion, fit(motion, model, lacking, start, TO_THE_END))
    (found,) = one_for_several(motion, begun).effects
    assert found.key == ("load", vertex)
    assert found.parameters["share"] == pytest.approx(share, rel=0.05)


@pytest.mark.slow
def test_several_worn_wheels_are_found_at_once_where_the_first_that_was_found_is_none_of_them(tmp_path: Path) -> None:
    worn = {2: 0.85, 7: 0.82, 9: 0.85, 10: 0.73}
    campaign = make(5, [Effect("worn_wheel", k, {"seizure": s}) for k, s in worn.items()], "short", COMBINATIONS[:4])
    write(campaign, tmp_path)
    motion, model = windows(tmp_path, campaign.eps)
    between = [ActiveEffect.of("worn_wheel", 8, seizure=0.5), ActiveEffect.of("wheel_mount", share=0.2)]
    motion, begun = calibrated(motion, fit(motion, model, between, np.array([campaign.eps, 0.5, 0.2]), TO_THE_END))
    found = all_at_once(motion, begun, len(candidates_of(begun)))
    assert found.chi2 < 0.5 * begun.chi2
    assert {e.place: e.parameters["seizure"] for e in found.effects} == pytest.approx(worn, abs=0.1)


@pytest.mark.parametrize(("joints", "asked"), [((1, 2, 3, 4, 5, 6), True), ((3,), False)])
def test_more_places_that_all_tell_than_a_body_of_so_many_joints_has_mend_the_law_and_are_no_cause(
    joints: tuple[int, ...], asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = Model(Body(vertices=8, joints=joints), Medium(anisotropy_ratio=0.2))
    told: list[set[str]] = []

    def fitted(motion: Motion, about: Model, effects: list[ActiveEffect], x: np.ndarray, *_: object) -> Fit:
        """All of them, by 0.1 and sure to 1e-3, and chance is left."""
        known = 1e6 * np.tile(np.eye(len(x)), (2, 1, 1))
        evidence = Evidence(known, np.zeros((2, len(x))), np.full(2, 50.0), np.full(2, 50.0))
        return Fit(with_values(about, effects, x + 0.1), evidence, (), 100.0)

    def kept(_: Motion, found: Fit, tries: int) -> Fit:
        told.append({e.name for e in found.effects})
        return found

    monkeypatch.setattr(all_places, "fit", fitted)
    monkeypatch.setattr(all_places, "told", kept)
    monkeypatch.setattr(all_places, "choose", lambda *_: None)
    motion: Any = Motion((), None, ())  # type: ignore[arg-type]
    poor = replace(fitted(motion, model, [], np.array([0.2])), chi2=1e4)
    assert all_at_once(motion, poor, len(candidates_of(poor))) is poor
    assert ({"load"} in told) == asked

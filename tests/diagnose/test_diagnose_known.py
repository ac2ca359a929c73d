"""What a model file says is known is no news, at whatever stage: an extended model goes back in."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.diagnose.campaign import diagnose_campaign
from serpenoid.diagnose.data.cameras.observation import values_of
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.start import taken_for_granted, unlike_body, unlike_kind
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.measure.campaign import CampaignFile, load_campaign_file
from serpenoid.medium import Medium
from serpenoid.model import Model
from specimens import problem

SNAKE = Path(__file__).parents[2] / "problems" / "snake10.toml"


@pytest.mark.slow
def test_the_extended_model_of_a_diagnosis_explains_its_campaign(
    campaign: Path, diagnosed: tuple[Diagnosis, dict[str, Any], Path]
) -> None:
    first, _, out = diagnosed
    assert {n.effect.name for n in first.named} == {"gain_loss", "load"}
    _, again = diagnose_campaign(campaign, out / "extended-model.toml")
    assert again.verdict == "nothing"
    assert {e.key for e in again.model.effects} >= {n.effect.key for n in first.named}


def test_a_model_of_another_body_is_said_to_be(campaign: Path, tmp_path: Path) -> None:
    file, heavy = load_campaign_file(campaign)[0], tmp_path / "heavy.toml"
    assert unlike_body(SNAKE, file) == ""
    weights = [2.0, *[1.0] * (file.body.vertices - 1)]
    heavy.write_text(f"[body]\nvertices = {file.body.vertices}\nlength_m = 0.9\nweights = {weights}\n")
    said = unlike_body(heavy, file)
    assert "`edge_lengths` by up to" in said
    assert "`weights` by up to" in said
    assert "the campaign's is used" in said


def test_a_model_of_another_kind_of_body_is_said_to_be(tmp_path: Path) -> None:
    own, bare, wheels = (tmp_path / f"{name}.toml" for name in ("own", "bare", "wheels"))
    wheels.write_text('[body]\nkind = "wheeled robot"\nvertices = 7\n')
    own.write_text('[body]\nkind = "crawler"\nvertices = 57\n')
    bare.write_text("[medium]\nanisotropy_ratio = 0.2\n")
    file = CampaignFile.model_construct(name="worm", body=Body(kind="crawler", vertices=5))
    assert unlike_kind(None, file) == unlike_kind(own, file) == unlike_kind(bare, file) == ""
    assert "is a wheeled robot, and the campaign `worm` records a crawler" in unlike_kind(wheels, file)


def test_known_effects_are_taken_for_granted_at_their_own_stages() -> None:
    body, heard = problem("snake10").body, []
    zero = ActiveEffect(name="zero_offset", place=3, offset=0.1)
    play = ActiveEffect(name="loose_joint", place=2, width=0.03)
    marker = ActiveEffect(name="marker_offset", place=4, along=4e-3, left=-5e-3)
    scale = ActiveEffect(name="length_scale", error=0.01)
    read = ActiveEffect(name="servo_lag", lag=0.05)
    drift, slope = ActiveEffect.typical("frame_drift"), ActiveEffect.typical("slope")
    clock = ActiveEffect.typical("clock_offset")
    model = Model(body, Medium(anisotropy_ratio=0.2), (zero, play, marker, scale, read, drift, slope, clock))
    known = taken_for_granted(model, False, frozenset(), heard.append)
    assert {e.name for e in known.model.effects} == {"frame_drift", "slope"}
    assert {e.name for e in known.others} == {
        "zero_offset",
        "loose_joint",
        "marker_offset",
        "length_scale",
        "servo_lag",
    }
    assert len(heard) == 1
    assert "`clock_offset`" in heard[0]
    seen = known.observation()
    for effect in (zero, play, marker, scale):
        np.testing.assert_allclose(values_of(body, seen, *effect.key), list(effect.parameters.values()))
    assert np.count_nonzero(seen.zeros) == np.count_nonzero(seen.gaps) == 1


def test_a_model_file_whose_steps_have_no_root_is_refused_with_its_effects(
    campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def without_root(*_: Any) -> Any:
        raise pickle.loads(pickle.dumps(NoPath("g0r1")))  # as another process sends it

    monkeypatch.setattr("serpenoid.diagnose.campaign.diagnose", without_root)
    extreme = tmp_path / "extreme.toml"
    effects = ('name = "power_law_drag"\nexponent = 0\n', 'name = "rough_skin"\nplace = 5\nroughness = 20\n')
    extreme.write_text("".join(f"[[effects]]\n{e}" for e in effects))
    with pytest.raises(InputError) as refused:
        diagnose_campaign(campaign, extreme)
    assert str(refused.value) == (
        f"{extreme}: trial `g0r1`: steps of this model have no root, so that it says nothing of how the body moved "
        "there. Drop one of its effects, or set it nearer to the value that changes nothing: `power_law_drag` "
        "(exponent = 0) and `rough_skin at vertex 5` (roughness = 20)."
    )

"""Floor, strength, separation, and the judgement of answers."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from blind import kinds, table
from blind.campaign import COMBINATIONS, Campaign, make
from blind.catalogue import CATALOGUE, Effect
from blind.handful import HANDFUL
from blind.protocol import usual
from blind.score import Name, answer, confusion, errors, judge, wilson
from blind.separation import STARTS, separation
from blind.strength import floor, strength
from blind.study import Study, run, run_one
from serpenoid.parallel import Workers

SLOPE = Effect("slope", None, {"pull_x": 0.003, "pull_y": 0.001})
ZERO = Effect("zero_offset", 1, {"offset": 0.03})


def short(hidden: list[Effect] | int) -> Campaign:
    """A campaign of two settings."""
    return make(5, hidden, "short", COMBINATIONS[:2])


@pytest.fixture(scope="module")
def sloping() -> Campaign:
    return short([SLOPE])


@pytest.fixture(scope="module")
def slope_floor(sloping: Campaign) -> float:
    return floor(sloping)


def test_the_floor_is_a_matter_of_millimetres_and_the_null_has_no_strength(slope_floor: float) -> None:
    assert 1e-4 < slope_floor < 5e-3
    assert strength(short(0), Effect("toe", None, {"angle": 0.0}), slope_floor) < 0.02


def test_the_floor_does_not_depend_on_what_is_hidden(slope_floor: float) -> None:
    assert floor(short([ZERO])) == pytest.approx(slope_floor, rel=0.25)
    assert floor(short([Effect("frame_drift", None, {"velocity_x": 0.004, "velocity_y": 0})])) < 1.25 * slope_floor


def test_a_rival_with_the_same_name_leaves_nothing(sloping: Campaign, slope_floor: float) -> None:
    assert strength(sloping, SLOPE, slope_floor) > 6
    assert separation(sloping, SLOPE, "slope", None, slope_floor) < 0.05


def test_an_unrelated_rival_leaves_almost_everything(sloping: Campaign, slope_floor: float) -> None:
    s = strength(sloping, SLOPE, slope_floor)
    assert separation(sloping, SLOPE, "worn_wheel", 9, slope_floor) > 0.8 * s
    assert separation(sloping, SLOPE, "servo_lag", None, slope_floor) == pytest.approx(s)
    assert separation(sloping, SLOPE, "magnet", None, slope_floor) == np.inf


def test_tail_marker_and_first_joints_zero_cannot_be_told_apart() -> None:
    c = short([ZERO])
    assert strength(c, ZERO, 1e-3) > 3
    assert separation(c, ZERO, "marker_offset", 0, 1e-3) < 1
    assert separation(c, ZERO, "marker_offset", 5, 1e-3) > 3


def test_every_rival_but_jumps_can_be_fitted() -> None:
    assert set(CATALOGUE) - set(STARTS) == {"position_jumps"}


def _said(verdict: str, *effects: dict, alternatives: list | None = None) -> dict:  # type: ignore[type-arg]
    return {"verdict": verdict, "effects": list(effects), "alternatives": alternatives or []}


@pytest.mark.parametrize(
    ("diagnosis", "strengths", "outcome"),
    [
        (_said("explained", {"name": "slope", "place": None}), [5.0], "right"),
        (_said("explained", {"name": "toe"}), [5.0], "wrong"),
        (_said("explained", {"name": "toe"}, alternatives=[{"name": "slope"}]), [5.0], "wrong"),
        (_said("explained", {"name": "frame_drift"}, alternatives=[{"name": "slope"}]), [5.0], "right"),
        (_said("explained", {"name": "slope"}, alternatives=[{"effects": [{"name": "toe"}]}]), [5.0], "wrong"),
        (_said("nothing"), [5.0], "missed"),
        (_said("unexplained"), [5.0], "missed"),
        (_said("nothing"), [2.0], "unscored"),
        (_said("explained", {"name": "slope"}), [2.0], "unscored"),
        (_said("nothing"), [0.5], "right"),
        (_said("explained", {"name": "toe"}), [0.5], "false alarm"),
        (_said("explained", {"name": "slope"}), [0.5], "right name below the floor"),
    ],
)
def test_judgement_of_one_effect(diagnosis: dict, strengths: list[float], outcome: str) -> None:  # type: ignore[type-arg]
    def separated(i: int, rival: Name) -> float:
        return 1.0 if rival.name == "frame_drift" else 9.0

    assert judge(answer(diagnosis), [SLOPE], strengths, separated).outcome == outcome


def test_judgement_of_nothing_and_of_two() -> None:
    def far(i: int, rival: Name) -> float:
        return 9.0

    assert judge(answer(_said("nothing")), [], [], far).outcome == "right"
    assert judge(answer(_said("unexplained")), [], [], far).outcome == "false doubt"
    assert judge(answer(_said("explained", {"name": "toe"})), [], [], far).outcome == "false alarm"
    both = _said("explained", {"name": "slope"}, {"name": "zero_offset", "place": "joint_1"})
    assert judge(answer(both), [SLOPE, ZERO], [5, 5], far).outcome == "right"
    half = _said("explained", {"name": "slope"})
    assert judge(answer(half), [SLOPE, ZERO], [5, 5], far).outcome == "wrong"
    assert judge(answer(half), [SLOPE, ZERO], [5, 2], far).outcome == "right"


def test_errors_look_at_rightly_named_effects_only() -> None:
    skewed = {
        "pull_x": {"value": 0.0035, "interval": [0.002, 0.004]},
        "pull_y": {"value": 0.002, "interval": [0.0015, None]},
    }
    said = _said("explained", {"name": "slope", "place": None, "parameters": skewed})
    assert errors(said, [SLOPE]) == {"slope.pull_x": pytest.approx(1 / 3), "slope.pull_y": pytest.approx(2.0)}
    assert errors(said, [ZERO]) == {}


def test_wilson_interval_of_a_textbook_case() -> None:
    """Newcombe 1998, table I, method 3: 81 of 263."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=1e-4)


def test_confusion_counts() -> None:
    assert confusion([("toe", "toe"), ("toe", "slope"), ("toe", "toe")]) == {"toe": {"slope": 1, "toe": 2}}


FAKE = """
import json, pathlib, sys
campaign, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[sys.argv.index("--out") + 1])
assert (campaign / "campaign.toml").exists()
out.mkdir(parents=True)
gain = {"path_rms_m": {"before": 1, "after": 0.001}}
diagnosis = {"verdict": "nothing", "effects": [], "alternatives": [], "gain": gain}
(out / "diagnosis.json").write_text(json.dumps(diagnosis))
"""


@pytest.fixture
def fake(tmp_path: Path) -> str:
    script = tmp_path / "fake.py"
    script.write_text(FAKE)
    return f"{sys.executable} {script}"


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Studies whose campaigns have two settings."""
    settings = COMBINATIONS[:2]
    monkeypatch.setattr(kinds, "usual", partial(usual, combinations=settings))
    monkeypatch.setattr(kinds, "make", partial(make, combinations=settings))


@pytest.mark.usefixtures("few")
def test_study_runs_scores_and_resumes(tmp_path: Path, fake: str) -> None:
    rows = run(Study("null", tmp_path / "out", "model.toml", fake), 2, Workers())
    assert [row["outcome"] for row in rows] == ["right", "right"]
    above, written = table.read(tmp_path / "out" / "null.csv")
    again = run(Study("null", tmp_path / "out", "model.toml", "no-such-command"), 2, Workers())
    assert again == written
    assert above["key"] == "blind-6"
    with pytest.raises(SystemExit, match="another key needs another --out"):
        run(Study("null", tmp_path / "out", "model.toml", fake, "another"), 2, Workers())


@pytest.mark.usefixtures("few")
def test_another_physics_is_asked_without_its_law_and_beside_its_healthy_self() -> None:
    study = Study("physics", Path("unused"), "unused", key="k")
    healthy, changed = study.case(0), study.case(5)
    assert healthy.without == changed.without == ("grip_saturation",)
    assert np.isfinite(healthy.campaign.world.ground.saturation_speed)
    assert healthy.reference is None
    assert changed.reference is not None
    assert len(changed.campaign.effects) == 1
    pairs = zip(changed.campaign.trials, changed.reference.trials, strict=True)
    assert all(np.array_equal(a.setting.plan.table, b.setting.plan.table) for a, b in pairs)
    assert not np.array_equal(changed.campaign.trials[0].drive.start, changed.reference.trials[0].drive.start)


@pytest.mark.usefixtures("few")
def test_what_stands_in_for_a_law_that_the_catalogue_lacks_is_wrong(tmp_path: Path, fake: str) -> None:
    row = run_one(Study("physics", tmp_path / "out", "model.toml", fake), 0)
    assert row["outcome"] == "right"
    assert 0 < row["eps_effective"] < 1


@pytest.mark.usefixtures("few")
def test_a_silent_diagnosis_misses_a_strong_effect_and_is_right_outside(tmp_path: Path, fake: str) -> None:
    row = run_one(Study("outside", tmp_path / "out", "model.toml", fake), 0)
    assert row["outcome"] == "right"
    row = run_one(Study("one", tmp_path / "out", "model.toml", fake), 0)
    assert row["strengths"][0] >= 3
    assert row["outcome"] == "missed"


ALWAYS = (4,)


@pytest.mark.parametrize(
    "index", [i if i in ALWAYS else pytest.param(i, marks=pytest.mark.slow) for i in range(1, len(HANDFUL))]
)
def test_the_handful_is_strong(index: int) -> None:
    study = Study("handful", Path("unused"), "unused")
    c = study.case(index).campaign
    assert strength(c, c.effects[0], floor(c)) >= 6


UNDECIDED = """
import json, pathlib, shutil, sys
campaign, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[sys.argv.index("--out") + 1])
out.mkdir(parents=True)
shutil.copy(campaign / "gaits" / "gait02.csv", out / "next.csv")
again = (campaign / "gaits" / "gait03.csv").exists()
diagnosis = {"verdict": "explained", "effects": [{"name": "slope"}], "alternatives": [] if again else [{"name": "toe"}]}
diagnosis["next_experiment"] = {"joint_table": "next.csv", "cycle_duration_s": 4.0}
(out / "diagnosis.json").write_text(json.dumps(diagnosis))
"""


@pytest.mark.slow  # three campaigns, of a kind of study that is seldom run
def test_the_proposed_experiment_is_played_beside_a_random_gait(tmp_path: Path) -> None:
    script = tmp_path / "undecided.py"
    script.write_text(UNDECIDED)
    row = run_one(Study("followup", tmp_path / "out", "model.toml", f"{sys.executable} {script}"), 0)
    assert (row["group_before"], row["group_proposed"], row["group_random"]) == (2, 1, 1)


@pytest.mark.usefixtures("few")
def test_a_diagnosis_that_fails_is_recorded(tmp_path: Path) -> None:
    row = run_one(Study("null", tmp_path, "model.toml", f"{sys.executable} -c raise(SystemExit(3))"), 0)
    assert row["outcome"] == "failed"
    row = run_one(Study("null", tmp_path, "model.toml", f"{sys.executable} -c raise(SystemExit(2))"), 0)
    assert row["outcome"] == "refused"

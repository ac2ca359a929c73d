"""A healthy campaign as reference: its own discrepancy is no news, and what changed since is named."""

import json
import re

import numpy as np
import pytest

from arena.hidden import HIDDEN, Hidden
from arena.study import PROTOCOL, Study, diagnosed, judged
from serpenoid.arena.campaign import run_campaign
from serpenoid.arena.protocol import load_protocol
from serpenoid.arena.trial import plans
from serpenoid.body import Body
from serpenoid.cli.main import main
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.inference.doubt.laws import on_rival
from serpenoid.diagnose.reference import reference_of
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.media import LAWS
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.model_file import write_model_file
from serpenoid.studies import in_use

FEW = ("gait-1", "gait-5")  # one of them tail first; two headings


def short_campaign(folder, seed, hidden):
    """Two of the six gaits, one cycle each, two repeats."""
    folder.mkdir()
    text = PROTOCOL.read_text(encoding="utf-8").replace('"six-gaits/', f'"{PROTOCOL.parent}/six-gaits/')
    (folder / "protocol.toml").write_text(text.replace("seed = 11", f"seed = {seed}") + hidden.toml)
    protocol, tables = load_protocol(folder / "protocol.toml")
    few = protocol.model_copy(update={"cycles": 1, "gait": tuple(g for g in protocol.gait if g.name in FEW)})
    return run_campaign(few, {name: tables[name] for name in FEW}, folder / "campaign")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("arena-diagnosis")


@pytest.fixture(scope="module")
def changed(folder):
    return short_campaign(folder / "changed", 23, HIDDEN["wrong-zero"])


@pytest.fixture(scope="module")
def then(folder) -> Diagnosis:
    """A minute's work: no law of the catalogue is that of the arena's servos, and many are tried."""
    return diagnosed(short_campaign(folder / "healthy", 21, Hidden()), None, folder / "then")[0]


@pytest.mark.slow
def test_markers_show_a_wrong_zero_without_a_reference(changed):
    _, recordings = read_recordings(changed)
    stage, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    (named,) = stage.named
    assert named.effect.key in HIDDEN["wrong-zero"].answers
    assert not named.stand_in
    low, high = named.intervals["offset"]
    assert low < np.radians(6.0) < high


@pytest.mark.slow
def test_the_healthy_robot_is_not_what_the_model_says(then):
    assert then.verdict in ("partly explained", "unexplained")
    # soft servos, told to jump from row to row
    assert {"servo_lag", "servo_inertia"} & {n.effect.name for n in then.named}
    assert any("motion: what is left repeats" in text for text in then.words)  # Coulomb contacts
    assert then.motion.stage.discrepancy_m > 1e-3
    # no law of the catalogue is Coulomb's with loads that move about, or a motor's that gives way to a load
    assert all(n.stand_in for n in then.named)


@pytest.mark.slow
def test_the_law_of_the_floor_is_asked(then):
    # by the anisotropy ratio alone the arena's contacts are nearer to dry friction than to linear drag
    told = r"alone, dry friction \(Coulomb\).* misses windows by ([\d.]+) times the noise and linear drag by ([\d.]+)"
    said = [alone for text in then.motion.stage.laws.values() if (alone := re.match(told, text))]
    assert said
    assert all(float(one[1]) < float(one[2]) for one in said)


def test_a_law_that_a_body_lacks_or_already_has_is_no_rival():
    body = Body(vertices=12)
    assert on_rival(Model(body, Medium(anisotropy_ratio=0.2, law="coulomb")), LAWS["coulomb"]) is None
    swimmer = Body(kind="swimmer", vertices=12)
    assert on_rival(Model(swimmer, Medium(anisotropy_ratio=0.2)), LAWS["coulomb"]) is None


@pytest.mark.slow
def test_another_day_with_the_healthy_robot_brings_no_news(then, folder):
    campaign = short_campaign(folder / "another", 22, Hidden())
    _, said = diagnosed(campaign, reference_of(then), folder / "another-out")
    assert said["verdict"] == "nothing"
    assert said["effects"] == []


@pytest.mark.slow
def test_a_wrong_zero_is_what_changed(then, changed, folder):
    _, said = diagnosed(changed, reference_of(then), folder / "changed-out")
    assert judged(said, HIDDEN["wrong-zero"])["outcome"] == "right"
    low, high = said["effects"][0]["parameters"]["offset"]["interval"]
    assert low < np.radians(6.0) < high


def test_each_gait_may_have_a_heading_of_its_own():
    protocol, _ = load_protocol(PROTOCOL)
    headings = {plan.gait: plan.heading_deg for plan in plans(protocol)}
    assert sorted(headings.values()) == [0, 0, 120, 120, 240, 240]
    assert len(plans(protocol)) == 12


def test_what_is_hidden_leaves_no_trace_in_the_campaign(changed, folder):
    texts = [p.read_text() for p in changed.rglob("*") if p.suffix in (".toml", ".json")]
    assert not any(word in text for text in texts for word in ("zero", "changes", "seed"))
    assert "zero" not in str(Study(folder).folder("wrong-zero"))


def test_gain_in_use_counts_what_both_gaits_did():
    gaits = {name: in_use.OptimalGait(np.zeros((50, 10)), 0.5, True) for name in in_use.MODELS}
    found = {"baseline": np.array([0.40, 0.42, 0.38]), "extended": np.array([0.50, 0.53, 0.47])}
    record = in_use.record_of(gaits, found)
    assert record["gain"] == pytest.approx(0.1)
    low, high = record["gain_interval"]
    # Welch by hand: variances 4e-4 and 9e-4 over 3; 3.48 degrees of freedom, t = 2.95
    assert high - 0.1 == pytest.approx(0.0614, abs=5e-4)
    assert 0.1 - low == pytest.approx(high - 0.1)


def test_use_plays_both_optimal_gaits_on_the_changed_robot(tmp_path, capsys):
    for name, ratio in (("baseline", 0.19), ("extended", 0.25)):
        write_model_file(tmp_path / f"{name}-model.toml", Medium(anisotropy_ratio=ratio), ())
    few = ["--trials", "2", "--cycles", "1", "--jobs", "1"]
    assert main(["arena", "use", str(tmp_path), str(PROTOCOL), *few, "--quiet"]) == 0
    record = json.loads((tmp_path / "in-use" / "in-use.json").read_text())
    assert len(record["extended"]["trials"]) == 2
    for name in in_use.MODELS:
        assert 0.2 < record[name]["mean"] < 0.9
        assert record[name]["certified"]
        assert record[name]["promised"] > 0.6  # the reference optimum, at another anisotropy ratio


@pytest.mark.parametrize("ratio", [0.2, None])
def test_use_of_a_diagnosis_without_two_models_is_refused_before_anything_is_written(tmp_path, capsys, ratio):
    """Of the same gait on both sides the difference was chance, and said as a gain."""
    for name in in_use.MODELS if ratio is not None else ():
        write_model_file(tmp_path / f"{name}-model.toml", Medium(anisotropy_ratio=ratio), ())
    assert main(["arena", "use", str(tmp_path), str(PROTOCOL)]) == 2
    said = "its two models are the same" if ratio is not None else "holds no baseline-model.toml"
    assert said in capsys.readouterr().err
    assert not (tmp_path / "in-use").exists()

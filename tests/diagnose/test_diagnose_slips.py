"""A law is the same in every frame: a horn that slips is no marker that sits elsewhere, and no zero that was wrong."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import usual, with_joints
from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.columns import columns_of
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR, lawful
from serpenoid.diagnose.inference.fits.prices import Priced
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.diagnose.stages.observation.marker_evidence import along, by_trial, channels_left, sample
from serpenoid.effects.active import ActiveEffect

SEED, JOINTS, JOINT, SLIP = 31, 6, 4, 0.15  # rad
FIRST = 1  # trials before the horn, or the marker, slips
MARKER = 3
PLAY = 0.2  # rad


@pytest.fixture(scope="module")
def slipped(tmp_path_factory: pytest.TempPathFactory) -> list[Recording]:
    """Three trials; from the second on a joint is bent by one angle more than its servo reads."""
    whole, before = tmp_path_factory.mktemp("after"), tmp_path_factory.mktemp("before")
    protocol = replace(with_joints(usual(SEED, COMBINATIONS[:1]), JOINTS), plays=3)
    write(make(SEED, [Effect("zero_offset", JOINT, {"offset": SLIP})], protocol=protocol), whole)
    write(make(SEED, [], protocol=protocol), before)
    after, healthy = read_recordings(whole)[1], read_recordings(before)[1]
    return [*healthy[:FIRST], *after[FIRST:]]


@pytest.mark.slow
def test_a_horn_that_slips_has_no_name_and_is_told_with_joint_trial_and_angle(slipped: list[Recording]) -> None:
    stage, _ = choose_observation(slipped, Observation.neutral(slipped[0].body))
    assert not stage.named
    told = re.search(rf"joint {JOINT} is bent by another angle .* by (\S+) rad at `(\S+)`", " ".join(stage.words))
    assert told is not None
    assert float(told[1]) == pytest.approx(SLIP, abs=3e-3)  # a marker's noise, averaged
    assert told[2] == slipped[FIRST].name
    assert re.search(
        r"zero_offset at joint \d would leave [67]\d% of what it does: not its law", " ".join(stage.words)
    )  # it leaves (1/3 2/3)^(1/2) SLIP of 2/3 SLIP: 71 %


def test_a_marker_that_slips_is_told_by_the_edge_and_divides_trials(tmp_path: Path) -> None:
    """One marker sits 0.8 mm farther along its link from the second trial on, which no joint shows."""
    protocol = with_joints(replace(usual(SEED, COMBINATIONS[:1]), plays=3), JOINTS)
    write(make(SEED, [], protocol=protocol), tmp_path)
    healthy = read_recordings(tmp_path)[1]
    moved = [replace(r, markers=_slid(r.markers, MARKER, 0.8e-3)) for r in healthy[FIRST:]]
    stage, _ = choose_observation([*healthy[:FIRST], *moved], Observation.neutral(healthy[0].body))
    assert stage.divided is not None
    assert stage.divided.others == tuple(r.name for r in healthy[:FIRST])
    assert stage.divided.changed == tuple(r.name for r in moved)
    told = re.search(r"the edge from vertex (\d+) is another length .* by (\S+) mm at `(\S+)`", stage.divided.words)
    assert told is not None
    edge, by, where = told.groups()
    assert int(edge) in (MARKER - 1, MARKER)
    assert float(by) == pytest.approx(-0.8 if int(edge) == MARKER else 0.8, abs=0.03)  # a marker's noise, averaged
    assert where == moved[0].name


@pytest.mark.slow
def test_play_in_some_trials_alone_divides_them(tmp_path: Path) -> None:
    """A screw that comes loose amid a campaign; play is no one angle in any of the trials."""
    protocol = with_joints(replace(usual(SEED, COMBINATIONS[:1]), plays=3), JOINTS)
    recordings = []
    for name, hidden in (("before", []), ("after", [Effect("loose_joint", JOINT, {"width": PLAY})])):
        write(make(SEED, hidden, protocol=protocol), tmp_path / name)
        recordings.append(read_recordings(tmp_path / name)[1])
    healthy, loose = recordings
    stage, _ = choose_observation([*healthy[:FIRST], *loose[FIRST:]], Observation.neutral(healthy[0].body))
    assert not stage.named
    assert stage.divided is not None
    assert stage.divided.perhaps
    assert stage.divided.others == tuple(r.name for r in healthy[:FIRST])
    assert stage.divided.words.startswith(f"joint {JOINT} is not as it should be in ")


def _slid(markers: Floats, at: int, by: float) -> Floats:
    """Markers (F, N, 2), one of them `by` [m] farther along the line to the next one."""
    ahead = markers[:, at + 1] - markers[:, at]
    found = markers.copy()
    found[:, at] += by * ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    return found


@pytest.mark.slow
def test_what_a_zero_leaves_of_what_it_does_is_as_much_as_trials_disagree(slipped: list[Recording]) -> None:
    body = slipped[0].body
    (column,) = columns_of(body, "zero_offset", JOINT)
    shares = []
    for trials, zero in ((slipped[: 2 * FIRST], SLIP / 2), (slipped[FIRST:], SLIP)):
        data = sample(trials)
        now = Observation.neutral(body).with_column(column, zero)
        left, done = along(data, now, [column], np.array([zero]))
        shares.append(np.sqrt(left / done))
    assert shares[0] == pytest.approx(1.0, abs=0.1)  # off by as much as it does, one way or the other
    assert shares[1] < 0.05
    data = sample(slipped)
    angles, about = by_trial(data, channels_left(data, Observation.neutral(body)), JOINT - 1)
    np.testing.assert_allclose(angles, [0, SLIP, SLIP], atol=2e-3)  # a marker's noise, averaged
    assert about < LAW_ERROR**2


def test_effects_are_refused_one_by_one_and_those_of_the_whole_body_by_more_than_they_do() -> None:
    found = [
        ActiveEffect.typical("backlash", 2),
        ActiveEffect.typical("gain_loss", 3),
        ActiveEffect.typical("servo_lag"),
    ]
    leaves = {"backlash": 0.4, "gain_loss": 0.3, "servo_lag": 0.9}

    class Some:
        def __init__(self, effects: list[ActiveEffect]):
            self.effects, self.size, self.priced = effects, len(effects), Priced(0.0, 0, 1.0)

    best, refused = lawful(
        Some(found),
        lambda s: s.effects,
        lambda s, e: leaves[e.name],
        lambda s, i: Some(s.effects[:i] + s.effects[i + 1 :]),
    )
    assert [e.name for e in best.effects] == ["gain_loss", "servo_lag"]
    assert refused == ("backlash at joint 2 would leave 40% of what it does: not its law",)

"""The ladder of residuals: what stands above its noise level, on which stage, before and after."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import serpenoid.diagnose.stages.whole as whole_of
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.stages.ladder import Error
from serpenoid.diagnose.stages.whole import whole_errors

Diagnosed = tuple[Diagnosis, dict[str, Any], Any]


def test_share_above_the_floor_is_of_the_mean_square() -> None:
    error = Error("motion", "m", 2.0, 1.0, 1.0)
    assert (error.share_above(2.0), error.share_above(1.0), error.share_above(0.5)) == (0.75, 0.0, 0.0)
    assert error.share_above(0.0) == 0.0


def test_every_rung_and_the_whole_have_error_floor_and_share(diagnosed: Diagnosed) -> None:
    steps = {s["stage"]: s for s in diagnosed[1]["ladder"]}
    assert list(steps) == ["actuation", "observation", "motion", "whole"]
    assert [len(steps[n]["parts"]) for n in steps] == [10, 12, 3, 0]
    for name in ("actuation", "motion", "whole"):  # 3 degrees of one joint, centimetres of path
        assert steps[name]["share_above_noise_before"] > 0.9
        assert steps[name]["after"] < 1.5 * steps[name]["noise_level"]
    healthy = steps["observation"]
    assert healthy["before"] == healthy["after"] == pytest.approx(healthy["noise_level"], rel=0.1)


def test_the_weak_joint_alone_stands_above_the_floor(diagnosed: Diagnosed) -> None:
    joints = diagnosed[0].ladder[0].parts
    assert [p.name for p in joints if p.before > 3 * p.noise_level] == ["joint 3"]
    assert all(p.after < 1.3 * p.noise_level for p in joints)


def test_from_command_to_path_the_weak_joint_counts(diagnosed: Diagnosed) -> None:
    d = diagnosed[0]
    whole, motion = (next(s.error for s in d.ladder if s.error.name == name) for name in ("whole", "motion"))
    recordings = [t.recording for t in d.motion.selection.motion.tracks]
    # a payload alone does not bring the commanded motion to the measured one; measured shapes need no weak joint
    _, payload_alone = whole_errors(recordings, Observation.neutral(recordings[0].body), d.motion, [], [])
    assert payload_alone > 1.5 * whole.after
    assert whole.after == pytest.approx(motion.after, abs=0.3 * whole.noise_level)


def test_where_the_model_has_no_path_along_raw_shapes_the_whole_is_judged_by_mended_ones(
    diagnosed: Diagnosed, monkeypatch: pytest.MonkeyPatch
) -> None:
    d = diagnosed[0]
    recordings = [t.recording for t in d.motion.selection.motion.tracks]
    neutral = Observation.neutral(recordings[0].body)
    off = replace(neutral, zeros=neutral.zeros + 1e-3)

    def none(*given: object) -> None:
        raise NoPath(recordings[0].name)

    monkeypatch.setattr(whole_of, "make_tracks", none)
    mended = whole_errors(recordings, neutral, d.motion, [], [])
    assert whole_errors(recordings, off, d.motion, [], []) == mended

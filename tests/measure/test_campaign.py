"""Campaign folders: a rehearsal read back gives its truth; what is broken, missing or in the wrong unit is named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rehearsal import EPS, ROOT, serpenoid_table, snake
from serpenoid.compare.calibrate import calibrate, estimate
from serpenoid.compare.lengths import lengths_sd, lengths_shift, others_of
from serpenoid.compare.rehearse import Laboratory, Rehearsal, write_campaign
from serpenoid.compare.segments import trial_segments
from serpenoid.compare.study import Study, compare_campaign, moving, shape_bias
from serpenoid.errors import InputError
from serpenoid.measure.load import Campaign, load_campaign
from serpenoid.measure.usage import usage
from serpenoid.model import Model

LAB = Laboratory(frames_per_second=60.0, lag_s=0.05)


@pytest.fixture(scope="module")
def rehearsed(tmp_path_factory) -> tuple[Path, Campaign, dict[str, Rehearsal]]:
    folder = tmp_path_factory.mktemp("campaign")
    tables = {"wide": serpenoid_table(40), "narrow": serpenoid_table(40, a=4.0, xi=1.3)}
    truths = write_campaign(folder, snake(), tables, LAB, 2, 0, cycle_duration_s=2.0, cycles=2, pause_s=1.0)
    return folder, load_campaign(folder), truths


@pytest.fixture(scope="module")
def study(rehearsed) -> Study:
    return compare_campaign(rehearsed[1], snake())


def test_clocks_and_schedule_are_found(rehearsed):
    _, campaign, _ = rehearsed
    for trial in campaign.trials:
        assert trial.start_source == "servo log"
        assert trial.servo.offset.offset_s == pytest.approx(LAB.servo_clock_s, abs=0.002)
        assert trial.schedule.start_s == pytest.approx(LAB.still_s, abs=0.003)
        assert [p.cycle for p in trial.passages] == [0, 1]
        assert trial.motion.jumps == ()
        assert all("number by number" in note for note in trial.notes)  # simulated servos read alike twice
    assert campaign.trials[0].notes == ()


def test_shapes_and_poses_are_the_truth_within_their_uncertainty(rehearsed):
    _, campaign, truths = rehearsed
    for trial in campaign.trials:
        truth, motion = truths[trial.name], trial.motion
        rows = trial.passages[0].frames
        angle_sd = np.sqrt(np.diagonal(motion.covariance[rows, 3:, 3:], axis1=1, axis2=2))
        z = (motion.joint_angles[rows] - truth.joint_angles[rows]) / angle_sd
        assert 0.3 < z.std() < 1.2  # the servos are taken to be a little worse than they are
        assert np.abs(motion.smooth_poses[rows, :2] - truth.poses[rows, :2]).max() < 5e-4  # two marker SDs


def test_displacement_is_the_truth_to_a_tenth_of_a_millimetre(rehearsed):
    _, campaign, truths = rehearsed
    for trial in campaign.trials:
        p = trial.passages[0]
        truth = np.hypot(*(truths[trial.name].poses[p.last] - truths[trial.name].poses[p.first])[:2])
        assert trial.displacement(p) == pytest.approx(
            truth, abs=4 * 0.06e-3 * 1.5 / 0.836
        )  # centroid SD 0.06 mm, two ends


def test_calibration_recovers_eps_singly_and_jointly(rehearsed):
    found = calibrate(rehearsed[1], snake(0.4), ("anisotropy_ratio",))
    assert found.together.values[0] == pytest.approx(EPS, abs=4 * found.together.sd[0])
    assert found.mean_best_rms == pytest.approx(EPS, rel=0.01)
    assert len(found.trials) == 4
    assert found.together.sd[0] < min(f.estimate.sd[0] for f in found.trials)


def test_actuation_and_motion_errors_add_up(study):
    for c in study.comparisons:
        whole, actuation, motion = (c.error(part) for part in ("whole", "actuation", "motion"))
        for key in ("forward", "left", "turn"):
            assert actuation[key] + motion[key] == pytest.approx(whole[key], abs=1e-12)
        assert (
            motion["path_rms"] < 0.2 * actuation["path_rms"]
        )  # only servo lag was injected: the ground is as modelled


def test_resimulated_displacement_scatters_as_stated(study):
    gap = np.array([c.exp.displacement - c.resim.displacement for c in study.comparisons])
    sd = np.array([c.resim_sd for c in study.comparisons])
    assert (np.abs(gap) < 5 * np.hypot(sd, 1e-4)).all()  # 1e-4: the measured ends
    bias = np.array([c.resim_bias for c in study.comparisons])
    assert (np.abs(bias) < 5 * sd).all()  # 0.2 mm on 0.8 m: noise moves what it scatters, not more
    assert not any("makes Resim" in note for note in study.notes)


def test_a_bias_of_resim_beyond_its_scatter_is_said(study):
    (first, *_) = study.comparisons
    told = shape_bias([replace(first, resim_bias=-0.01 * first.resim.displacement, resim_sd=1e-4)])
    assert told[0].startswith("noise of the measured shapes makes Resim 1.0% shorter")
    assert shape_bias([replace(first, resim_bias=-0.001 * first.resim.displacement, resim_sd=1e-4)]) == []


def test_a_gait_that_does_not_move_the_body_beyond_its_markers_noise_is_compared_with_nothing(study):
    assert moving(list(study.comparisons)) == (list(study.comparisons), [])
    rng = np.random.default_rng(8)
    (gait, *_) = study.gaits
    resting = []
    for c in study.comparisons:
        poses = c.exp.poses.copy()
        poses[:, :2] = rng.normal(scale=c.exp_sd / 2, size=(len(poses), 2))  # two ends, two directions: exp_sd
        resting.append(replace(c, exp=replace(c.exp, poses=poses)) if c.gait == gait else c)
    kept, said = moving(resting)
    assert kept == [c for c in resting if c.gait != gait]
    assert said[0].startswith(f"{gait}: the body moved no farther than the markers' noise")


def test_idle_power_and_dissipation_coefficient_are_recovered(study):
    assert study.power is not None
    assert study.power.idle_W == pytest.approx(LAB.idle_W, rel=0.01)
    assert study.power.coefficient_W == pytest.approx(LAB.dissipation_W, rel=0.03)
    assert all(cycle.aligned for cycle in study.cycles)


def test_ratios_of_a_faithful_model_have_no_bias(study):
    resim = next(s for s in study.ratios if s.pair == "Exp/Resim")
    assert resim.bias == pytest.approx(1.0, abs=2e-3)
    assert resim.wrong_pairs == ()


def _copy(folder: Path, target: Path, *edits: tuple[str, str]) -> Path:
    text = (folder / "campaign.toml").read_text()
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    (target / "campaign.toml").write_text(text.replace('= "', f'= "{folder}/') if not edits else text)
    for name in folder.iterdir():
        if name.is_dir():
            (target / name.name).symlink_to(name)
    return target


@pytest.mark.parametrize(
    ("edit", "match"),
    [
        (('motion = "wide-1/motion.csv"', 'motion = "wide-1/mtion.csv"'), "trial `wide-1`: .*mtion.csv: no such file"),
        (('motion = "wide-1/motion.csv"', 'motion = "wide-1/servo.csv"'), "row 1, column A: a Motive export starts"),
        (
            ("cycle_duration_s = 2.0", "cycle_duraton_s = 2.0"),
            r"cycle_duraton_s: unknown key. Did you mean `cycle_duration_s`",
        ),
        (('name = "wide-2"', 'name = "wide-1"'), "trial names must be unique, but `wide-1` is there twice"),
        (('"Snake:vertex_0", ', ""), "`markers` needs 12 names, got 11"),
        (("[0.0418, 0.0836", "[41.8, 0.0836"), r"0\.001 times as far apart.*`metres_per_pixel`"),
        (('format = "motive"', 'format = "motiv"'), "format: .*'motive', 'vicon'.*got 'motiv'"),
        (("format = 1", "format = 2"), "format: .*got 2"),
    ],
)
def test_broken_campaigns_are_refused(rehearsed, tmp_path, edit, match):
    if "41.8" in edit[1]:
        text = (rehearsed[0] / "campaign.toml").read_text()
        line = next(row for row in text.splitlines() if row.startswith("edge_lengths"))
        edit = (line, "edge_lengths = [41.8, " + ", ".join(["83.6"] * 9) + ", 41.8]")
    with pytest.raises(InputError, match=match):
        load_campaign(_copy(rehearsed[0], tmp_path, edit))


def test_every_broken_trial_is_named_at_once(rehearsed, tmp_path):
    edits = (('motion = "wide-1/', 'motion = "x1/'), ('servo_log = "narrow-2/', 'servo_log = "x2/'))
    with pytest.raises(InputError) as error:
        load_campaign(_copy(rehearsed[0], tmp_path, *edits))
    said = str(error.value)
    assert all(word in said for word in ("`wide-1`", "`narrow-2`", "x1/motion.csv", "x2/servo.csv"))


def test_logs_may_be_missing(rehearsed, tmp_path):
    edits = [(f'{kind} = "{name}/{file}.csv"\n', "") for name in ("wide-1", "wide-2", "narrow-1", "narrow-2")
             for kind, file in (("servo_log", "servo"), ("power_log", "power"))]  # fmt: skip
    campaign = load_campaign(_copy(rehearsed[0], tmp_path, *edits))
    for trial in campaign.trials:
        assert trial.start_source == "shape"
        # laid over measured shapes, the start takes the servo's lag with it
        assert trial.schedule.start_s == pytest.approx(LAB.still_s + LAB.lag_s, abs=0.02)
        assert len(trial.passages) == 2


def test_tidy_files_are_in_vertex_order_whatever_markers_are_called(rehearsed, tmp_path):
    _, campaign, truths = rehearsed
    truth, length = truths["wide-1"], campaign.body.total_length_m
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(12))
    table = np.column_stack([truth.time_s, (truth.vertices * length).reshape(len(truth.time_s), -1)])
    folder = _copy(rehearsed[0], tmp_path, ('format = "motive"', 'format = "tidy"'), ("wide-1/motion.csv", "tidy.csv"))
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text[: text.index("[[trial]]", text.index("[[trial]]") + 5)])
    np.savetxt(folder / "tidy.csv", table, delimiter=",", header=header, comments="")
    motion = load_campaign(folder).trials[0].motion
    np.testing.assert_allclose(motion.smooth_poses[:, :2], truth.poses[:, :2], atol=1e-5)  # smoothing of the kinks


def test_a_folder_without_campaign_says_what_to_do(tmp_path):
    for path, fault in ((tmp_path, "holds no campaign.toml"), (tmp_path / "none", "no such file or folder")):
        with pytest.raises(InputError, match=rf"{fault}.*serpenoid new campaign.*docs/campaign-format.md"):
            load_campaign(path)
    (tmp_path / "campaign.toml").mkdir()
    with pytest.raises(InputError, match=r"campaign.toml: is a folder, where a file of this name belongs"):
        load_campaign(tmp_path)


@pytest.mark.parametrize("fish", [pytest.param("lamprey", marks=pytest.mark.slow), "prickleback"])
def test_drag_with_k_2_predicts_about_an_eighth_of_a_fish_path(fish):
    campaign = load_campaign(ROOT / "problems" / "campaigns" / f"{fish}.toml")
    assert campaign.lengths_estimated
    study = compare_campaign(campaign, snake_of(campaign))
    share = float(study.displacement["Resim"][0] / study.displacement["Exp"][0])
    # 12 to 13 % is known from outside, for equal weights; a uniform body's end points weigh half: up to 2 % less
    assert 0.10 < share < 0.14


def snake_of(campaign: Campaign):
    from serpenoid.model import Model

    return Model(campaign.body, campaign.file.medium)


def test_all_pieces_of_a_recording_with_long_gaps_are_used(rehearsed, tmp_path):
    """An animal hidden twice for half a second: what lies between the holes counts, in fits and comparisons alike."""
    truth, length = rehearsed[2]["wide-1"], rehearsed[1].body.total_length_m
    points = truth.vertices * length
    time = truth.time_s - truth.time_s[0]
    for begin in (1.4, 3.0):
        points[(time >= begin) & (time < begin + 0.5)] = np.nan
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(12))
    table = np.column_stack([time, points.reshape(len(time), -1)])
    np.savetxt(tmp_path / "tidy.csv", table, delimiter=",", header=header, comments="")
    head = (rehearsed[0] / "campaign.toml").read_text()
    body = head[: head.index("[motion]")]
    rest = '[motion]\nformat = "tidy"\n\n[[trial]]\nname = "hidden"\nmotion = "tidy.csv"\n'
    (tmp_path / "campaign.toml").write_text(body + rest)
    campaign = load_campaign(tmp_path)
    used = usage(campaign.trials[0])
    assert used.pieces == 3
    assert used.used_s == pytest.approx(time[-1] - 2 * 0.5, abs=0.1)  # a frame and a row at either end of every hole
    assert used.dropped_s == pytest.approx(2 * 0.5, abs=0.1)
    found = compare_campaign(campaign, snake())
    (one,) = found.comparisons
    assert one.pieces == 3
    assert one.time_s[-1] - one.time_s[0] == pytest.approx(used.used_s, abs=1e-9)
    assert one.error("motion")["path_rms"] < 1e-3  # the model's own motion: smoothing alone differs
    assert any("dropped" in note for note in found.notes)


@pytest.mark.slow
def test_not_knowing_the_lengths_moves_eps_as_a_fit_with_other_lengths_does(rehearsed, tmp_path):
    """The jackknife's first-order shifts are those of whole fits; with lengths given there is nothing to add."""
    folder, given, _ = rehearsed
    lines = (folder / "campaign.toml").read_text().splitlines()
    (lengths,) = [line for line in lines if line.startswith("edge_lengths")]
    campaign = load_campaign(_copy(folder, tmp_path, (lengths, "")))
    model, trial = Model(campaign.body, snake().medium), campaign.trials[0]
    others = others_of(campaign, model)(trial.name)
    base = estimate(model, trial_segments(trial), ("anisotropy_ratio",))
    told = [float(lengths_shift(m, s, base.solution)[0]) for m, s in zip(others.models, others.segments, strict=True)]
    block = int(np.argmax(np.abs(told)))
    again = estimate(others.models[block], others.segments[block], ("anisotropy_ratio",))
    assert again.values[0] - base.values[0] == pytest.approx(told[block], rel=0.05)  # to first order
    wider = estimate(model, trial_segments(trial), ("anisotropy_ratio",), others).sd[0]
    assert wider == pytest.approx(np.hypot(base.sd[0], lengths_sd(others, base.solution)[0]))
    assert wider > 1.02 * base.sd[0]
    assert others_of(given, model)(None).models == ()


def test_where_markers_show_no_shape_is_said_and_not_fitted(rehearsed):
    """Points are exchanged in a trial whose data are believed: a fit of what is not finite ended in a traceback."""
    trial = rehearsed[1].trials[0]
    angles = trial.motion.smooth_angles.copy()
    row = trial.passages[0].first + 20
    angles[row] = np.nan
    with pytest.raises(InputError, match=f"no shape at {trial.motion.time_s[row]:.4g} s"):
        trial_segments(replace(trial, motion=replace(trial.motion, smooth_angles=angles)))


def test_files_that_are_written_while_they_are_read_are_refused_and_not_kept(tmp_path, monkeypatch):
    from serpenoid.measure import load

    write_campaign(tmp_path, snake(), {"gait": serpenoid_table(40)}, LAB, 1, 0, cycle_duration_s=2.0, cycles=1)
    film = next(tmp_path.rglob("motion.csv"))
    whole, aligned = film.read_bytes(), load._aligned

    def while_copied(*words):
        read = aligned(*words)
        film.write_bytes(whole + b"\n")
        return read

    monkeypatch.setattr(load, "_aligned", while_copied)
    with pytest.raises(InputError, match="its files were written while they were read"):
        load_campaign(tmp_path)
    monkeypatch.setattr(load, "_aligned", aligned)
    assert len(load_campaign(tmp_path).trials) == 1


def test_a_mass_that_may_be_grams_is_asked_about(tmp_path):
    write_campaign(tmp_path, snake(), {"gait": serpenoid_table(40)}, LAB, 1, 0, cycle_duration_s=2.0, cycles=1)
    file = tmp_path / "campaign.toml"
    lines = [line for line in file.read_text().splitlines() if not line.startswith("mass_kg")]
    file.write_text("\n".join(lines).replace("[body]\n", "[body]\nmass_kg = 1380\n"))
    (trial,) = load_campaign(tmp_path).trials
    assert [note for note in trial.notes if "was it given in grams?" in note]

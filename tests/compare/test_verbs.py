"""The verbs as a user meets them: a folder in, numbers and pictures out, rubbish refused, Ctrl-C clean."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rehearsal import EPS, serpenoid_table, snake
from serpenoid.cli.main import main
from serpenoid.compare.rehearse import Laboratory, write_campaign

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("lab")
    lab = Laboratory(frames_per_second=30.0)
    tables = {"A-c0.5": serpenoid_table(30), "A-c1.0": serpenoid_table(30, a=4.0)}
    write_campaign(path, snake(), tables, lab, 2, 0, cycle_duration_s=2.0, cycles=1, pause_s=1.0)
    text = (path / "campaign.toml").read_text()
    for c in ("0.5", "1.0"):
        text = text.replace(f'gait = "A-c{c}"\n', f'gait = "A-c{c}"\ndissipation_coefficient = {c}\n')
    (path / "campaign.toml").write_text(text)
    return path


def test_measure_writes_a_record_and_a_picture_of_every_trial(folder, tmp_path, capsys):
    assert main(["measure", str(folder), "--out", str(tmp_path)]) == 0
    record = json.loads((tmp_path / "campaign.json").read_text())
    assert [t["trial"] for t in record["trials"]] == ["A-c0.5-1", "A-c0.5-2", "A-c1.0-1", "A-c1.0-2"]
    assert record["trials"][0]["marker_sd_mm"] == pytest.approx(0.2, rel=0.1)
    assert (tmp_path / "trial-A-c0.5-1.png").stat().st_size > 10_000
    assert (tmp_path / "repeats-A-c0.5.svg").exists()
    assert "A-c1.0-2" in capsys.readouterr().out


def test_measure_says_of_all_trials_at_once_what_they_share(folder, tmp_path, capsys):
    shutil.copytree(folder, tmp_path / "c")
    toml = tmp_path / "c" / "campaign.toml"
    row = next(line for line in toml.read_text().splitlines() if line.startswith("edge_lengths"))
    *others, tail = row.rstrip("]").split(", ")
    longer = ", ".join([*others, f"{1.07 * float(tail):.6f}]"])
    toml.write_text(toml.read_text().replace(row, longer))
    assert main(["measure", str(tmp_path / "c"), "--out", str(tmp_path / "out"), "--no-figures"]) == 0
    said = capsys.readouterr().out
    assert said.count("shorter in the film, other links are as said") == 1
    assert said.index("note              all 4 trials: from `") < said.index("A-c0.5-1")
    record = json.loads((tmp_path / "out" / "campaign.json").read_text())
    assert all("shorter in the film" in "".join(trial["notes"]) for trial in record["trials"])


def test_fit_prints_json_and_nothing_else(folder, tmp_path, capsys):
    assert main(["fit", str(folder), "--out", str(tmp_path), "--json"]) == 0
    out, err = capsys.readouterr()
    record = json.loads(out)
    assert err == ""
    assert record["together"]["values"]["anisotropy_ratio"] == pytest.approx(EPS, rel=0.005)
    assert (tmp_path / "displacement-for-eps.png").exists()
    assert (tmp_path / "calibration.svg").exists()


def test_fit_says_beside_the_papers_number_which_one_is_the_answer(folder, tmp_path, capsys):
    assert main(["fit", str(folder), "--out", str(tmp_path), "--no-figures"]) == 0
    said = capsys.readouterr().out
    beside = said[said.index("best-RMS eps") : said.index("what is left")]
    assert "the answer is K" in beside
    assert "distance from the start" in beside


def test_compare_quiet_without_figures_writes_numbers_only(folder, tmp_path, capsys):
    assert (
        main(
            ["compare", str(folder), "--anisotropy-ratio", "0.1865", "--out", str(tmp_path), "--quiet", "--no-figures"]
        )
        == 0
    )
    assert capsys.readouterr().out == ""
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "compare.json",
        "comparison.csv",
        "request.json",
        "summary.txt",
    ]
    record = json.loads((tmp_path / "compare.json").read_text())
    assert [p["dissipation_coefficient"] for p in record["cost_of_transport"]] == [0.5, 1.0]


@pytest.mark.skipif(BROWSER is None, reason="no chromium: apt-get install chromium")
def test_the_report_runs_in_a_real_browser(folder, tmp_path):
    assert main(["compare", str(folder), "--out", str(tmp_path), "--quiet"]) == 0
    report = tmp_path / "report.html"
    text = report.read_text()
    assert "http://" not in text.replace("http://www.w3.org", "")
    assert "https://" not in text
    lone = tmp_path / "lone"
    lone.mkdir()
    shutil.copy(report, lone / "report.html")  # it needs nothing beside it
    probe = "<script>window.onerror=m=>{document.body.dataset.fault=m};</script>"
    scrub = (
        "<script>{const s=document.getElementById('scrub'),c=document.getElementById('stage');"
        "const ink=()=>{const d=c.getContext('2d').getImageData(0,0,c.width,c.height).data;let n=0;"
        "for(let i=3;i<d.length;i+=4)n+=d[i]>0?(i%9973):0;return n};const a=ink();"
        "s.value=s.max;s.oninput();document.body.dataset.moved=(ink()!==a);"
        "document.body.dataset.clock=document.getElementById('clock').textContent;"
        "document.body.dataset.images=[...document.images].every(i=>i.complete&&i.naturalWidth>50)}</script>"
    )
    html = text.replace("<body>", "<body>" + probe, 1).replace("</body>", scrub + "</body>", 1)
    (lone / "report.html").write_text(html)
    dom = _browse(lone / "report.html", tmp_path)
    assert 'data-ready="yes"' in dom
    assert "data-fault" not in dom
    assert 'data-moved="true"' in dom
    assert re.search(r'data-clock="2\.[45]', dom)  # two seconds of gait and half the pause, to a frame


def _browse(page: Path, home: Path) -> str:
    command = [
        str(BROWSER),
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-dev-shm-usage",
        "--virtual-time-budget=3000",
    ]
    command += [f"--user-data-dir={home / 'profile'}", "--dump-dom", page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout


@pytest.mark.parametrize("verb", ["measure", "fit", "compare"])
def test_rubbish_is_refused_in_one_sentence(verb, tmp_path, capsys):
    assert main([verb, str(tmp_path / "nothing")]) == 2
    assert "no such file" in capsys.readouterr().err
    (tmp_path / "campaign.toml").write_text("format = 1\nname = [")
    assert main([verb, str(tmp_path)]) == 2
    assert "not valid TOML" in capsys.readouterr().err


def test_a_wrong_parameter_and_a_wrong_eps_are_refused(folder, tmp_path, capsys):
    assert main(["fit", str(folder), "--parameter", "eps", "--quiet", "--out", str(tmp_path)]) == 2
    assert "one can fit anisotropy_ratio" in capsys.readouterr().err
    assert main(["compare", str(folder), "--anisotropy-ratio", "3", "--quiet", "--out", str(tmp_path)]) == 2
    assert "must be in (0, 1]" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_exits_with_130_and_leaves_no_half_written_file(folder, tmp_path):
    wait = 1.6
    for _ in range(12):
        process, error = interrupted(folder, tmp_path / "out", wait)
        if process.returncode not in (0, -signal.SIGINT):
            break
        wait *= 0.7 if process.returncode == 0 else 1.2  # finished before the signal; Python had not begun to listen
    assert process.returncode == 130
    assert "stopped" in error
    assert "Traceback" not in error
    left = [p.name for p in (tmp_path / "out").glob(".*")] if (tmp_path / "out").exists() else []
    assert left == []


def interrupted(folder: Path, out: Path, wait: float) -> tuple[subprocess.Popen, str]:
    command = [sys.executable, "-m", "serpenoid", "compare", str(folder), "--out", str(out)]
    source = Path(__file__).resolve().parents[2] / "src"
    process = subprocess.Popen(
        command,
        env={**os.environ, "PYTHONPATH": str(source)},
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    time.sleep(wait)
    process.send_signal(signal.SIGINT)
    return process, process.communicate(timeout=60)[1]


MARKUP = '<img src=x onerror="alert(1)"> {{data}} {{ 7*7 }} </script><script>alert(2)</script>'


def test_whatever_a_campaign_says_stands_in_the_report_as_text(folder, tmp_path):
    own = tmp_path / "lab"
    shutil.copytree(folder, own)
    text = (own / "campaign.toml").read_text()
    said = f"description = '''{MARKUP}'''\nsource = '''{MARKUP}'''\n"
    (own / "campaign.toml").write_text(re.sub(r"^(description|source) = .*\n", "", text, flags=re.M))
    text = (own / "campaign.toml").read_text()
    (own / "campaign.toml").write_text(re.sub(r"(?m)^name = .*\n", f"name = '''{MARKUP}'''\n{said}", text, count=1))
    assert main(["compare", str(own), "--anisotropy-ratio", "0.1865", "--out", str(tmp_path / "out"), "--quiet"]) == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "&lt;img src=x onerror=" in page
    assert "<img src=x" not in page
    assert "{{data}} {{ 7*7 }}" in page  # said, not replaced
    assert len(re.findall(r"<script", page)) == 3  # the page's own

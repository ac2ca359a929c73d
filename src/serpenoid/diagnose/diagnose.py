"""The whole diagnosis: three rungs from command to motion, a verdict, and what it rests on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from serpenoid.diagnose.baseline import Baseline
from serpenoid.diagnose.choose_actuation import choose_actuation
from serpenoid.diagnose.choose_motion import MotionFinding, choose_motion
from serpenoid.diagnose.choose_observation import choose_observation
from serpenoid.diagnose.finding import Named, Rival, Rung
from serpenoid.diagnose.gain import Scores, gain_record, held_out, scores
from serpenoid.diagnose.observation import Observation
from serpenoid.diagnose.recording import Recording
from serpenoid.model import Model


@dataclass(frozen=True)
class Diagnosis:
    """Verdict, rungs from top to bottom, the motion's evidence, and scores on held-out gaits before and after.

    baseline: what was taken for granted; seen: the observation model.
    """

    verdict: str
    baseline: Baseline
    seen: Observation
    rungs: tuple[Rung, ...]
    motion: MotionFinding
    before: Scores
    after: Scores

    @property
    def named(self) -> tuple[Named, ...]:
        """All effects named."""
        return tuple(n for rung in self.rungs for n in rung.named)

    @property
    def rivals(self) -> tuple[Rival, ...]:
        """What cannot be told apart from them."""
        return tuple(r for rung in self.rungs for r in rung.rivals)

    @property
    def words(self) -> tuple[str, ...]:
        """What is left above chance."""
        return tuple(f"{rung.name}: {w}" for rung in self.rungs for w in rung.words)

    @property
    def model(self) -> Model:
        """The extended model: what was known before, what the motion's fit found, and what the upper rungs did."""
        fitted = self.motion.selection.best.model
        every = (*self.baseline.known, *(n.effect for n in self.named), *fitted.effects)
        return Model(fitted.body, fitted.medium, tuple({(e.name, e.place): e for e in every}.values()))


def diagnose(recordings: Sequence[Recording], baseline: Baseline, say: Callable[[str], None]) -> Diagnosis:
    """From recordings to a verdict on what is new beside the baseline."""
    say("command against shape")
    actuation = choose_actuation(baseline.plays(recordings))
    say("shape against markers")
    observation, seen = choose_observation(recordings, baseline.observation())
    say("shape against motion")
    motion = choose_motion(recordings, seen, baseline, say)
    rungs = (actuation, observation, motion.rung)
    say("gain on held-out gaits")
    found = motion.selection
    jumps = any(n.effect.name == "position_jumps" for n in motion.rung.named)
    before = scores(found.motion, held_out(found.motion, found.null))
    after = scores(found.motion, held_out(found.motion, found.best), jumps)
    return Diagnosis(verdict(rungs), baseline, seen, rungs, motion, before, after)


def verdict(rungs: Sequence[Rung]) -> str:
    """One of four: only what has no structure left on any rung is explained."""
    named = any(rung.named for rung in rungs)
    settled = all(rung.settled for rung in rungs)
    if settled:
        return "explained" if named else "nothing"
    return "partly explained" if named else "unexplained"


def record(d: Diagnosis) -> dict[str, Any]:
    """diagnosis.json, but for the next experiment."""
    found = d.motion.selection
    return {
        "verdict": d.verdict,
        "effects": [n.record() for n in d.named],
        "alternatives": [r.record() for r in d.rivals],
        "below_the_floor": [{"name": e.name, "place": e.place} for rung in d.rungs for e in rung.faint],
        "anisotropy_ratio": {
            "before": found.null.model.medium.anisotropy_ratio, "after": found.best.model.medium.anisotropy_ratio,
        },
        "gain": gain_record(d.before, d.after),
        "noise_floor_m": found.floor_m,
        "left": {rung.name: rung.left for rung in d.rungs},
        "residual_pattern": list(d.words),
        "next_experiment": None,
        "scores": [{"name": n, "place": p, "held_out_gain": s} for n, p, s in found.scores[:20]],
    }  # fmt: skip

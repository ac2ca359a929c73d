"""How much of its recordings a diagnosis is made from, and what was noticed as they were read."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.data.noise.repeats import chance_from
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.recordings.single_markers import told
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.effects.base import Parameter
from serpenoid.measure.usage import Usage, said_once
from serpenoid.media import LAWS

CHANCE = {
    "residuals": "nothing was played twice, so what the model leaves is taken for noise, an error of the model as "
    "well: play every setting twice to tell them apart",
    "cycles": "no setting was played twice: noise is what cycles of one trial differ by, and what differs from trial "
    "to trial passes for an error of the model; play every setting twice to tell them apart",
}


def used(tracks: Sequence[Track]) -> Usage:
    """Seconds of all windows with both ends measured, of what the schedules promise (animals: of what was recorded)."""
    recordings = {track.recording.name: track.recording for track in tracks}
    begun = [np.diff(track.usable.astype(int), prepend=0) == 1 for track in tracks]
    return Usage(
        float(sum(r.promised_s for r in recordings.values())),
        float(sum(track.duration[track.usable].sum() for track in tracks)),
        int(sum(b.sum() for b in begun)),
    )


def remarks(tracks: Sequence[Track]) -> tuple[str, ...]:
    """Each once: what the campaign's check against itself had to say, but for cameras, and what tells chance if trials
    do not."""
    checked = said_once((t.recording.name, _said(t, cameras=False)) for t in tracks)
    poor = CHANCE.get(chance_from(tracks))
    return (*([poor] if poor else []), *checked, *_strays(tracks))


def about_cameras(tracks: Sequence[Track]) -> tuple[str, ...]:
    """Each once: what films show of their cameras, with the trials, if it is not of all."""
    said = {t.recording.name: _said(t, cameras=True) for t in tracks}
    of_all = set.intersection(*map(set, said.values())) if said else set()
    own = said_once((name, [text for text in texts if text not in of_all]) for name, texts in said.items())
    return (*dict.fromkeys(text for texts in said.values() for text in texts if text in of_all), *own)


def _said(track: Track, cameras: bool) -> list[str]:
    """Words of the remarks on a track's recording that are about cameras, or of all others."""
    return [remark.words for remark in track.recording.remarks if (remark.kind == "cameras") == cameras]


def _strays(tracks: Sequence[Track]) -> tuple[str, ...]:
    """What is said of markers that are off in single frames, of all trials together."""
    recordings = {t.recording.name: t.recording for t in tracks if isinstance(t.recording, Recording)}
    with_some = [r.strays for r in recordings.values() if r.strays]
    return (told([one for strays in with_some for one in strays], len(with_some)),) if with_some else ()


def length_unit(tracks: Sequence[Track]) -> str:
    """What lengths are in: `m`, or `bl` (body lengths) where a recording does not know its scale."""
    return "bl" if any(track.recording.length_unit == "bl" for track in tracks) else "m"


def parameter_unit(p: Parameter, law: str, length: str) -> str:
    """A parameter's unit in a medium of this law, with `length` in the place of metres."""
    return re.sub(r"\bm(?=\d?\b)", length, p.unit_in(LAWS[law]))

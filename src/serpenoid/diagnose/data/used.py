"""How much of its recordings a diagnosis is made from, and what was noticed as they were read."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.data.windows import Track
from serpenoid.measure.usage import Usage


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
    """`trial: remark`, each once."""
    return tuple(dict.fromkeys(f"{t.recording.name}: {text}" for t in tracks for text in t.recording.remarks))

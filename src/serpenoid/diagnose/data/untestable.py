"""Effects that a recording cannot speak about, with the reason: they are no candidates, and the record says so.

Where the medium's anisotropy ratio has bounds, an effect that scales the ratio itself would carry it beyond them. Where
an animal swims one way all the time, a push of the room cannot be told from a thrust of the body that is missing.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from serpenoid.body import Body
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.effects.base import MediumEffect
from serpenoid.effects.catalogue import catalogue
from serpenoid.model import Model

ONE_WAY = 0.9  # mean resultant length of all headings: an SD of 26 degrees


def not_on_offer(body: Body) -> frozenset[str]:
    """Names of effects that need what this kind of body does not have: nobody asks for a swimmer's wheels."""
    return frozenset(k.name for k in catalogue().values() if not k.needs <= body.parts)


def of_other_laws(law: str) -> frozenset[str]:
    """Names of effects that do not act in a medium of this law: dry friction is none on top of Coulomb's."""
    return frozenset(k.name for k in catalogue().values() if not k.acts_in(law))


def left_out(names: Collection[str]) -> dict[str, str]:
    """Names that were asked to be left out."""
    return dict.fromkeys(sorted(names), "it was left out of the catalogue (--without)")


def beyond_bounds(model: Model) -> dict[str, str]:
    """Names of effects that would undo the medium's bounds."""
    bounds = model.medium.anisotropy_ratio_bounds
    if bounds is None or not model.medium.limited_by_physics:
        return {}
    reason = f"it scales the anisotropy ratio, which this medium keeps within {bounds[0]:g} .. {bounds[1]:g}"
    return {k.name: reason for k in catalogue().values() if isinstance(k, MediumEffect) and k.scales_ratio}


def fixed_to_the_room(tracks: Sequence[Track]) -> dict[str, str]:
    """Names of effects that depend on place or heading, where all tracks head one way."""
    heading = np.concatenate([t.poses[:, 2] for t in tracks])
    resultant = float(np.abs(np.exp(1j * heading).mean()))
    if resultant < ONE_WAY:
        return {}
    spread = np.degrees(np.sqrt(-2 * np.log(resultant)))
    reason = f"fixed to the room, and the body heads one way all the time (SD {spread:.0f} degrees)"
    return dict.fromkeys(sorted(k.name for k in catalogue().values() if k.of_the_room), reason)

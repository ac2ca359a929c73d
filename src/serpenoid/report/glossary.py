"""Words of the reports that a reader may ask about, each in a sentence; the pages show them on hover and on touch."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from markupsafe import Markup

TERMS = {
    "noise level": "what repeated trials of a gait differ by: an error as small as this tells nothing",
    "held-out gaits": "gaits that the model was not fitted to: each is predicted from a fit to all the others",
    "gaits not fitted": "each gait is predicted from a fit to all the others, so the model has not seen it",
    "baseline": "the model as it was given, with its anisotropy ratio calibrated to the recording",
    "extended model": "the baseline and the effects that were found",
    "anisotropy ratio": "friction along the body over friction across it (eps): 0 is a perfect wheel, 1 a disc",
    "path RMS": "root mean square distance between the predicted and the measured path of the centroid",
    "chi squared": "squared errors in units of their standard deviations, summed",
    "below detection": "its trace is as small as noise makes, or its value may be one that changes nothing: not named",
    "stage": "a comparison between command and motion: actuation, observation or motion",
    "residual": "measured minus predicted",
    "log-likelihood": "how probable the recording is under the model: more is better",
    "Exp": "what the cameras saw",
    "Resim": "measured shapes, simulated",
    "Sim": "commanded shapes, simulated",
    "95 %": "interval that holds the true value in 95 of 100 such experiments",
}
_PATTERN = re.compile(r"(?<![\w-])(" + "|".join(sorted(map(re.escape, TERMS), key=len, reverse=True)) + r")(?![\w-])")
_CODE = re.compile("`([^`]+)`")


def glossed(text: object) -> Markup:
    """Escaped text in which the first mention of each term carries its explanation; what stands in ` is code."""
    from markupsafe import Markup, escape

    met: set[str] = set()

    def marked(found: re.Match[str]) -> str:
        term = found[1]
        if term in met:
            return term
        met.add(term)
        return f'<abbr tabindex="0" title="{escape(TERMS[term])}">{term}</abbr>'

    return Markup(_CODE.sub(r"<code>\1</code>", _PATTERN.sub(marked, str(escape(text)))))

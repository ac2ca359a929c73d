"""Links of the documents that lead out of docs/, into the repository: on the site, their text alone."""

import re
from pathlib import PurePosixPath

LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(((?:\.\./)+)[^)]*\)")


def on_page_markdown(markdown, page, **_):
    """A link that climbs out of docs/ becomes plain text: where the repository stands is not known here."""
    depth = len(PurePosixPath(page.file.src_path).parts) - 1
    return LINK.sub(lambda link: link[1] if link[2].count("../") > depth else link[0], markdown)

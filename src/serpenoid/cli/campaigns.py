"""What `measure`, `fit`, `compare` and `diagnose` share: the campaign argument, its progress, its results folder."""

from __future__ import annotations

import argparse
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.cli import options
from serpenoid.cli.claim import content_of_campaign
from serpenoid.errors import InputError

if TYPE_CHECKING:
    from serpenoid.measure.load import Campaign


HELP_WIDTH = 120  # columns of the text that says what a verb does
KEPT = "What was read and computed is kept: the same command goes on from there."


def formats_line() -> str:
    """Every format of motion files that is read, for the end of a verb's help."""
    return textwrap.fill(f"Formats of motion files (`format` in [motion]): {formats()}.", HELP_WIDTH)


def formats() -> str:
    """Their names, from the list of readers."""
    from serpenoid.measure.formats.readers import NAMES

    return ", ".join(NAMES)


def add_campaign(parser: argparse.ArgumentParser) -> None:
    """CAMPAIGN."""
    parser.set_defaults(kept_if_stopped=KEPT)
    help_line = "folder with campaign.toml, or the TOML file itself (docs/campaign-format.md)"
    parser.add_argument("campaign", metavar="CAMPAIGN", help=help_line)


def add_model(
    parser: argparse.ArgumentParser, ratio: str = "eps to simulate with (default: the campaign's [medium], else fitted)"
) -> None:
    """--anisotropy-ratio, --dissipation; ratio: what the first is for."""
    parser.add_argument("--anisotropy-ratio", type=float, metavar="EPS", help=ratio)
    kinds = ("vertex", "edge")
    parser.add_argument(
        "--dissipation", choices=kinds, help="where a robot's drag elements sit (default: [medium], else vertex)"
    )


def read(args: argparse.Namespace) -> Campaign:
    """Load the campaign with a progress bar."""
    from serpenoid.measure.campaign import load_campaign_file
    from serpenoid.measure.load import load_campaign

    file, _ = load_campaign_file(args.campaign)
    with options.progress_bar(args, "reading", len(file.trial)) as advance:
        campaign = load_campaign(args.campaign, lambda done, total, name: advance(done, name))
        advance(len(file.trial))
    return campaign


def refuse_elements(args: argparse.Namespace, campaign: Campaign) -> None:
    """InputError where --dissipation asks of an animal for what it has not."""
    if args.dissipation is not None and campaign.body.is_animal:
        raise InputError("--dissipation: drag acts all along an animal's body, at no vertices or edges. Leave it out.")


def folder(args: argparse.Namespace, campaign: str, verb: str, *extra: Any) -> Path:
    """--out, or results/<campaign>/<verb>-<hash>: of the campaign's content, and of what else the answer depends on."""
    from serpenoid.files.writing import short_hash

    key = short_hash(content_of_campaign(campaign), *extra)
    return options.output_folder(args, Path("results") / name_of(campaign) / f"{verb}-{key}", key)


def name_of(campaign: str) -> str:
    """Of the folder, or of a file that does not bear the usual name."""
    path = Path(campaign).resolve()
    if path.is_dir():
        return path.name
    return path.parent.name if path.name == "campaign.toml" else path.stem

"""Campaigns that come with the program: the published tables, and raw loops of an independent virtual rig."""

from __future__ import annotations

from importlib import resources
from pathlib import Path


def bundled_campaigns() -> tuple[str, ...]:
    """Give the names of the bundled campaigns."""
    return tuple(sorted(folder.name for folder in _home().iterdir() if folder.is_dir()))


def bundled_campaign(name: str) -> Path:
    """Give the folder of a campaign that comes with the program."""
    return _home() / name


def campaign_folder(path: Path) -> Path:
    """Give the campaign's folder that a user means: the path, or a bundled campaign where there is no such folder."""
    name = str(path)
    return bundled_campaign(name) if not path.exists() and name in bundled_campaigns() else path


def _home() -> Path:
    return Path(str(resources.files("pipeclamp_identification").joinpath("data", "campaigns")))

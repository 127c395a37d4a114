"""Campaigns that come with the program: the published tables, and raw loops of an independent virtual rig."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.files import set_aside
from pipeclamp_models.law.bundled import refuse_effect


def bundled_campaigns() -> tuple[str, ...]:
    """Give the names of the bundled campaigns."""
    return tuple(sorted(folder.name for folder in _home().iterdir() if folder.is_dir()))


def bundled_campaign(name: str) -> Path:
    """Give the folder of a campaign that comes with the program."""
    return _home() / name


def campaign_folder(path: Path) -> Path:
    """Give the campaign's folder that a user means: the path, or a bundled campaign where there is no such folder.

    Raises:
        UserError: there is neither such a folder nor such a bundled campaign.
    """
    if path.exists() or set_aside(path).is_dir():
        return path
    name, names = str(path), bundled_campaigns()
    if name in names:
        return bundled_campaign(name)
    refuse_effect(name, "a campaign")
    raise UserError(
        f"{path}: no such folder, and no bundled campaign of that name; {did_you_mean(name, names)}expected a "
        f"campaign's folder with campaign.toml and runs.csv, or one of {', '.join(names)}"
    )


def _home() -> Path:
    return Path(str(resources.files("pipeclamp_identification").joinpath("data", "campaigns")))

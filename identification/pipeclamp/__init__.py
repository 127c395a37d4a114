"""The front door of pipeclamp: what people call, see and read. Nothing is computed here.

Its packages, each importing only those before it: show, pages, api, studio, cli.
`import pipeclamp as pc` gives the functions below; what each needs is loaded when it is first called.

>>> import pipeclamp as pc
>>> tests = pc.read_campaign("clamp_a")
>>> law = pc.identify(tests)
>>> print(f"{pc.compare(law, tests).nrmse:.2%}")
2.55%
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipeclamp.api.comparison import Comparison, LawsComparison, compare, compare_laws
    from pipeclamp.api.diagnosis import Diagnosis, diagnose
    from pipeclamp.api.discovery import Discovery, discover
    from pipeclamp.api.fmu import build_fmu, build_pipe
    from pipeclamp.api.importing import Import, import_files
    from pipeclamp.api.law import Law, open_law
    from pipeclamp.api.laws import add, identify, identify_per, refit, remove
    from pipeclamp.api.planning import LoopTests, PlannedCampaign, plan, plan_campaign
    from pipeclamp.api.system import Cosimulation, cosim
    from pipeclamp.api.tests import Tests, read_campaign
    from pipeclamp_models.base.errors import UserError

__all__ = [
    "Comparison", "Cosimulation", "Diagnosis", "Discovery", "Import", "Law", "LawsComparison", "LoopTests",
    "PlannedCampaign", "Tests", "UserError", "add", "build_fmu", "build_pipe", "compare", "compare_laws", "cosim",
    "diagnose", "discover", "identify", "identify_per", "import_files", "open_law", "plan", "plan_campaign",
    "read_campaign", "refit", "remove",
]  # fmt: skip

_HOMES = {
    "Comparison": "pipeclamp.api.comparison",
    "Cosimulation": "pipeclamp.api.system",
    "Diagnosis": "pipeclamp.api.diagnosis",
    "Discovery": "pipeclamp.api.discovery",
    "Import": "pipeclamp.api.importing",
    "Law": "pipeclamp.api.law",
    "LawsComparison": "pipeclamp.api.comparison",
    "LoopTests": "pipeclamp.api.planning",
    "Tests": "pipeclamp.api.tests",
    "UserError": "pipeclamp_models.base.errors",
    "add": "pipeclamp.api.laws",
    "build_fmu": "pipeclamp.api.fmu",
    "build_pipe": "pipeclamp.api.fmu",
    "compare": "pipeclamp.api.comparison",
    "compare_laws": "pipeclamp.api.comparison",
    "cosim": "pipeclamp.api.system",
    "diagnose": "pipeclamp.api.diagnosis",
    "discover": "pipeclamp.api.discovery",
    "identify": "pipeclamp.api.laws",
    "identify_per": "pipeclamp.api.laws",
    "import_files": "pipeclamp.api.importing",
    "open_law": "pipeclamp.api.law",
    "PlannedCampaign": "pipeclamp.api.planning",
    "plan": "pipeclamp.api.planning",
    "plan_campaign": "pipeclamp.api.planning",
    "read_campaign": "pipeclamp.api.tests",
    "refit": "pipeclamp.api.laws",
    "remove": "pipeclamp.api.laws",
}


def __getattr__(name: str) -> object:
    """Load a public name when it is first used."""
    if name == "__version__":
        from importlib.metadata import version

        return version("pipeclamp")
    if name not in _HOMES:
        raise AttributeError(f"module 'pipeclamp' has no attribute {name!r}")
    found = getattr(import_module(_HOMES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Give the public names, loaded or not, and none of what this file needs itself."""
    return sorted({*(name for name in globals() if name.startswith("__")), *__all__})

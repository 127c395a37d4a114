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
    from pipeclamp.api.catalogue import Catalogue, effects, schema
    from pipeclamp.api.comparison import Comparison, LawsComparison, compare, compare_laws
    from pipeclamp.api.diagnosis import Diagnosis, diagnose
    from pipeclamp.api.discovery import Discovery, discover
    from pipeclamp.api.fmu import SystemPackage, build_fmu, build_pipe, build_system, set_parameters
    from pipeclamp.api.importing import Import, import_files
    from pipeclamp.api.law import Law, open_law
    from pipeclamp.api.laws import add, identify, identify_per, refit, remove
    from pipeclamp.api.on_pipe import PipeComparison, compare_pipe
    from pipeclamp.api.planning import LoopTests, PlannedCampaign, plan, plan_campaign
    from pipeclamp.api.response import Response, response
    from pipeclamp.api.study import Sweep, sweep
    from pipeclamp.api.system import Cosimulation, cosim
    from pipeclamp.api.tests import Tests, read_campaign
    from pipeclamp.api.virtual import Rig, join, rig
    from pipeclamp_models.base.errors import UserError

__all__ = [
    "Catalogue", "Comparison", "Cosimulation", "Diagnosis", "Discovery", "Import", "Law", "LawsComparison",
    "LoopTests", "PipeComparison", "PlannedCampaign", "Response", "Rig", "Sweep", "SystemPackage", "Tests",
    "UserError", "add", "build_fmu", "build_pipe", "build_system", "compare", "compare_laws", "compare_pipe",
    "cosim", "diagnose", "discover", "effects", "identify", "identify_per", "import_files", "join", "open_law",
    "plan", "plan_campaign", "read_campaign", "refit", "remove", "response", "rig", "schema", "set_parameters",
    "sweep",
]  # fmt: skip

_HOMES = {
    "Catalogue": "pipeclamp.api.catalogue",
    "Comparison": "pipeclamp.api.comparison",
    "Cosimulation": "pipeclamp.api.system",
    "Diagnosis": "pipeclamp.api.diagnosis",
    "Discovery": "pipeclamp.api.discovery",
    "Import": "pipeclamp.api.importing",
    "Law": "pipeclamp.api.law",
    "LawsComparison": "pipeclamp.api.comparison",
    "LoopTests": "pipeclamp.api.planning",
    "PipeComparison": "pipeclamp.api.on_pipe",
    "PlannedCampaign": "pipeclamp.api.planning",
    "Response": "pipeclamp.api.response",
    "Rig": "pipeclamp.api.virtual",
    "Sweep": "pipeclamp.api.study",
    "SystemPackage": "pipeclamp.api.fmu",
    "Tests": "pipeclamp.api.tests",
    "UserError": "pipeclamp_models.base.errors",
    "add": "pipeclamp.api.laws",
    "build_fmu": "pipeclamp.api.fmu",
    "build_pipe": "pipeclamp.api.fmu",
    "build_system": "pipeclamp.api.fmu",
    "compare": "pipeclamp.api.comparison",
    "compare_laws": "pipeclamp.api.comparison",
    "compare_pipe": "pipeclamp.api.on_pipe",
    "cosim": "pipeclamp.api.system",
    "diagnose": "pipeclamp.api.diagnosis",
    "discover": "pipeclamp.api.discovery",
    "effects": "pipeclamp.api.catalogue",
    "identify": "pipeclamp.api.laws",
    "identify_per": "pipeclamp.api.laws",
    "import_files": "pipeclamp.api.importing",
    "join": "pipeclamp.api.virtual",
    "open_law": "pipeclamp.api.law",
    "plan": "pipeclamp.api.planning",
    "plan_campaign": "pipeclamp.api.planning",
    "read_campaign": "pipeclamp.api.tests",
    "refit": "pipeclamp.api.laws",
    "remove": "pipeclamp.api.laws",
    "response": "pipeclamp.api.response",
    "rig": "pipeclamp.api.virtual",
    "schema": "pipeclamp.api.catalogue",
    "set_parameters": "pipeclamp.api.fmu",
    "sweep": "pipeclamp.api.study",
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

"""What stands behind a law, for machines: data, each coefficient's origin, error, scatter, the last diagnosis."""

from __future__ import annotations

import json
from collections.abc import Mapping

from pipeclamp_fmu.contents.parameter_sets import ParameterSets
from pipeclamp_models.law.file import CoefficientState, LawFile

SCHEMA = "pipeclamp-credibility-1"

EVIDENCE: Mapping[CoefficientState, str] = {
    "fitted": "measured",
    "held": "assumed",
    "frozen": "assumed",
    "at_bound": "assumed",
    "given": "given",
}
"""What kind of knowledge a coefficient is, by its state in the law's file."""

NEVER = "never diagnosed"
"""The verdict of a law whose file tells of no diagnosis since it was last changed."""


def verdict_of(file: LawFile) -> str:
    """Give the verdict of the law's last diagnosis in words."""
    if file.diagnosis is None:
        return f"{NEVER}: the law's file tells of no diagnosis since the law was last changed"
    named = f" ({', '.join(file.diagnosis.effects)})" if file.diagnosis.effects else ""
    return f"{file.diagnosis.verdict}{named}, on {file.diagnosis.tests}"


def credibility(file: LawFile, sets: ParameterSets, software: str) -> bytes:
    """Give the record, JSON.

    Args:
        file: the law.
        sets: its parameter sets.
        software: the program that writes it.
    """
    told = file.model_dump(by_alias=True, exclude_none=True, mode="json")
    record = {
        "schema": SCHEMA,
        "law": {key: told[key] for key in ("name", "base", "effects", "software")},
        "software": software,
        "data": told["data"],
        "range": told["range"],
        "coefficients": {
            name: {"evidence": EVIDENCE[entry.state], **told["coefficients"][name]}
            for name, entry in file.coefficients.items()
        },
        "fit": told.get("fit"),
        "spread": told.get("spread"),
        "history": [
            {key: step[key] for key in ("step", "nrmse", "refitted_nrmse") if key in step} for step in told["history"]
        ],
        "diagnosis": told.get("diagnosis", {"verdict": NEVER}),
        "parameter_sets": [
            {
                "name": entry.name,
                "source": f"{entry.name}.ssv",
                "meaning": entry.meaning,
                "dissipated_energy_mJ": entry.loss,
                "stiffness_N_mm": entry.stiffness,
            }
            for entry in sets.sets
        ],
        "cautions": sets.cautions,
    }
    return (json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode("utf-8")

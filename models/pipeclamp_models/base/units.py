"""Temperatures on their two scales."""

from __future__ import annotations

CELSIUS = 273.15
"""0 degC in K."""

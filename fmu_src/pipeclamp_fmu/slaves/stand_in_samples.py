"""An excitation in the form in which excitations enter their slave: what the builder replaces by a generated one."""

from __future__ import annotations

STEP = 0.1
VALUES: tuple[float, ...] = (0.0, 1.0, 0.0)

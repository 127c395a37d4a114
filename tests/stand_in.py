"""Numbers for the stand-in law: round ones of the size of the published clamp, nobody's measurements."""

from pipeclamp_fmu.slaves.stand_in_law import COEFFICIENTS

VALUES = dict(zip(COEFFICIENTS, (1200.0, -0.2, 150.0, 180.0, -0.3, 0.47, 0.012, 500.0, 60.0, 0.0126), strict=True))
RANGES = ((0.2, 1.0), (1.0, 5.0), (293.15, 573.15))
"""Of A (mm), f (Hz), T (K)."""

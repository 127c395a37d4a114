"""What decides a verdict on records, each threshold with its kind in its name and its reason.

A *chance* is that of noise alone; a *share* is of the force noise, of the force, of the lack of fit, or of loops, as
said; a *likelihood* is a difference of Akaike's criterion.
"""

from __future__ import annotations

import numpy as np

REAL_LACK_CHANCE = 1e-3
"""Lack of fit less likely than this under noise alone is real."""
MATERIAL_NOISE_SHARE = 0.1
"""Lack of fit below this share of the force noise (rms) isn't worth an effect: it costs half a percent of the floor."""
MATERIAL_FORCE_SHARE = 2e-4
"""Nor is what lies below this share of the force (rms): few load cells are truer."""
FORM_SHARE = 0.1
"""What no effect explains may be this share (rms) of what the bare base law lacks, and pass for the form of the law's
effects: real effects rarely have a catalogue's exact form."""
FORM_NOISE_SHARE = 0.75
"""But no more than this share of the force noise: with it, a law's error is a quarter above the floor. What leaves over
more doesn't fit in its form either."""
CAUSE_NOISE_SHARE = 0.5
"""An effect that leaves more than this share of the force noise, following the conditions, takes a part: with it, a
law's error is an eighth above the floor, and a cause's form fits better."""
UNEXPLAINED_SHARE = 0.3
"""A best candidate that leaves over more than this share (rms) of the lack of fit doesn't explain it."""
HALF_LEFT_SHARE = 0.5
"""Nor does one that leaves over more than half (rms) of it, however small what is left: at the edge of what is material
or significant, next to nothing decides on which side a law lies."""
HALF_TAKEN_SHARE = 0.5
"""What may be the form of the law's effects is another effect only if that takes half of the mean square on left-out
conditions: any effect takes some of a wrong form."""
MATERIAL_PART_SHARE = 0.05
"""A part that is worth a rung takes this share of the mean-square lack of fit: the error beyond scatter falls by a
fortieth."""
TAKEN_SHARE = MATERIAL_PART_SHARE / 5
"""Nothing is gained by an effect that, refitted, takes less than this share of the mean square beyond scatter on
left-out conditions, with parameters that nothing determines: it may be another form of what the law has."""
PROMISED_SHARE = 0.5
"""A rung takes much less than was estimated where it is less than this share, by refits without what was left out."""
SAME_ERROR_SHARE = 0.02
"""An error (rms) on left-out temperatures, specimens or further conditions that rises by less is the same: an effect
that doesn't follow these moves it by a hair either way."""
BEYOND_DOUBT_DRAWS_SHARE = 0.975
"""And it gains on left-out groups in more than this share of draws of them with replacement."""
NEAR_NOISE_SHARE = 5.0
"""Where the best effect still leaves more than so many times the force noise, no second one is tried with it: the best
takes its part first, and what remains is asked of the catalogue with it in the law."""
SAME_PART_SHARE = 0.5
"""Two effects rival each other for a part where one takes less than this share beside the other of what it takes alone;
otherwise both are missing."""
ALONE_SHARE = UNEXPLAINED_SHARE**2
"""Of two effects that explain it together, the one to name must explain this share (mean square) alone: two that do so
only against each other are terms of a series, not physics."""
RIVAL_DRAWS_SHARE = 0.1
"""A rival stays in the answer's set when resampling the runs makes it the best in this share of the draws."""
RIVAL_LIKELIHOOD = 2 * np.log(100.0)
"""A rival also stays when the fit to all data leaves it a hundredth of the best's likelihood: where few conditions were
tested, leaving one out asks for what the rest can't tell, and its errors aren't evidence."""
WORTH_FITTING_SHARE = 0.01
"""A candidate passes the screen when one step promises this share of what the best promises."""
WORTH_CLOSELY_SHARE = 0.2
"""And is fitted closely when a rough fit gains this share of what the best one's does."""
LARGER_MEMBER_SQUARES = 10.0
"""Difference in squares on left-out groups that is no reason for an effect's larger member."""
MOSTLY_STUCK_SHARE = 0.5
"""Of an element that never slips in this share of the loops or more, these don't show what it can hold: it stands for a
mean force, whatever this is. One that sticks in the smallest loops and slips in the others holds what it may."""
RUN_APART_SHARE = 0.5
"""A run that holds more of what is left over (mean square) than all others together stands apart."""
FEWEST_RUNS = 4
"""Fewer can't show what a law lacks."""
FEWEST_GROUPS = 6
"""Fewer groups of A and f can't show a term beyond the catalogue: some are kept back from the search for it."""

LINE_NOISE_RATIO = 2.0
"""A line is locked to time when half of the runs show it so many times above the noise: a few spectra have outliers of
their own."""
LINE_STANDARD_ERRORS = 12.0
"""And when its pooled power exceeds its neighbours' by so many standard errors: hundreds of bins are looked at."""
HALVES_CHANCE = 1e-4
"""Halves of the drive's frequency that noise makes so strong with less than this chance are there."""
STILL_AS_GOOD = 1.025
"""An error that rises beyond this ratio does so by a material part: an effect without which it does stays, and values
with which it falls so far are other ones."""
WORTH_POWERS_RATIO = 1.1
"""Beside memory, powers of the amplitude stay in a law that isn't complete where its error rises beyond this ratio
without them: what they take from sines they cost several times over along motions that are none."""


def ratio_without_powers(complete: bool) -> float:
    """Give the ratio by which a law's error may rise where powers of the amplitude are held at 0 beside its memory.

    Args:
        complete: whether nothing is missing; then the error stays the same, but for what isn't material.
    """
    return STILL_AS_GOOD if complete else WORTH_POWERS_RATIO

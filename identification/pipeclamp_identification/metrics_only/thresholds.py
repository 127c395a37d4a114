"""What decides a verdict on metrics without records, each threshold with its kind in its name and its reason.

A *chance* is that of scatter alone; a *share* is of what is said; a *likelihood* is a difference of Akaike's criterion.
"""

from __future__ import annotations

import numpy as np

from pipeclamp_identification.diagnosis.thresholds import RIVAL_DRAWS_SHARE

REAL_CHANCE = 0.05
"""A gain or a lack less likely than this under scatter alone is real; a gain's chance counts once for each effect that
was tried."""
GREATER_PART_SHARE = 0.5
"""An effect is named when it alone gains this share of what the richest law gains: not one patch of many."""
PAIR_TAKES_SHARE = 0.5
"""Two effects are named together when they take this share, or more, of what the best one alone would leave."""
HOPELESS_CHANCE = 0.5
"""An effect whose gain scatter makes in this share of all cases isn't weighed further."""
FEWEST_FREEDOMS = 4
"""With fewer metrics beyond the law's parameters there is nothing to judge a law by."""
RIVAL_LIKELIHOOD = -2 * float(np.log(RIVAL_DRAWS_SHARE))
"""A rival stays in the answer's set when its likelihood, each parameter counted, is a tenth of the best's or more."""
RESTS_ON_SHARE = 0.5
"""An effect rests on one row when leaving that row out takes away more than this share of what it gains."""
UNSEEN_SHARE = 0.05
"""Metrics that change by no more than this share of what the force changes by don't show an effect: the points of a
coarse cycle alone make a percent, and what shows makes half of it or more."""
IMITATED_SHARE = 0.02
"""An effect of which the law's own parameters leave no more than this share can't be told from them."""
NEARLY_ALL_SHARE = 0.9
"""An effect that explains this share of the squares that the richest law explains is named as the cause; with less it
takes a part."""
WRONG_AT_MOST_LOG = float(np.log(1e3))
"""What a law foretells of a left-out condition counts as wrong by this factor at most, so also where it makes energy,
which has no log: one condition then rules the law out, and no mean of errors lacks a number."""

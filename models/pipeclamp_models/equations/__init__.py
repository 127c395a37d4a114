"""What an effect is made of: symbols with units and bounds, expressions, states and their updates.

An effect states its equation once, in these words; everything else is derived from it.
The effects themselves stand in the room beside this one.
"""

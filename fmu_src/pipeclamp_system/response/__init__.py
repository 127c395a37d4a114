"""The frequency response of a coupled system: curves over temperatures and levels, and co-simulations on them.

Its steady states are found in the room before; here they are followed over a range, told and tabled.
"""

"""Test machines' files become campaigns: read, their channels named and in our units, cut into runs, repaired, written.

`formats` holds one reader a format; `channels` says which of a file's channels is what. What files become is a campaign
of records or one of results: `records` and `results` make them, behind one request, with answers of one shape. Nothing
is written before all is known: a plan, which is data, comes first. Whatever was done to the data is told in it, and
kept in the campaign's file.
"""

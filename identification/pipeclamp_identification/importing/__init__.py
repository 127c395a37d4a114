"""Test machines' files become campaigns: read, their channels named and in our units, cut into runs, repaired, written.

`formats` holds one reader a format. Nothing is written before all is known: a plan, which is data, comes first.
Whatever was done to the data is told in it, and kept in the campaign's file.
"""

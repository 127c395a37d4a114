"""Campaigns of records: read, checked, cut into cycles, written, joined, and made by a virtual rig.

Bad data is named with file, row and column here, so that the rooms behind can rely on what they get.
Campaigns that come with the package are found here too.
"""

"""Records of tests become a campaign of records: files are taken piece by piece, and their runs get names and rows.

The plan that comes of it is written, read back as any reader does, and looked at. What was found, with its loops and
its judged runs, is what pages and answers are made of.
"""

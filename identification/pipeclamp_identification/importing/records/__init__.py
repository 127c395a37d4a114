"""Records of tests become a campaign of records: the plan is written, read back as any reader does, and looked at.

What was found, with its loops and its judged runs, is what pages and answers are made of.
"""

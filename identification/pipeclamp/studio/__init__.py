"""The studio: a campaign and its laws in the browser, for people who don't program.

It serves pages on this machine alone; whatever it shows comes from the rooms below, and whatever it makes is a file
that the commands read. Long work runs in processes of its own.
"""

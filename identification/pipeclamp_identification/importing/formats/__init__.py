"""Formats of test machines' files, one a module: each has a `FORMAT`.

The folder is the list: a module more is a format more.
No module here parses what a well-kept library reads.
"""

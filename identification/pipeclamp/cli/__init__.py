"""The command line: reads, calls, writes and prints.

What a command needs is imported inside it, so that light commands start fast.
Everything it does can be done from Python too.
"""

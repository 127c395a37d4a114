"""Units of test data: stated in names and turned into ours, doubted where numbers contradict them.

A unit that is stated counts; one that contradicts what else is stated is refused, one that is only unlikely is told.
"""

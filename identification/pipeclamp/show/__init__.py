"""What people read: answers told in sentences and tables, for terminals, notebooks and pages.

Nothing is computed here, and nothing is drawn.
Pictures and pages stand in the room beside this one.
"""
